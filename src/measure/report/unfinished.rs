//! What an interrupted report has measured, so that another run can go on with it: a file beside the page.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Bench, Section, Written, setting};
use crate::error::{Input, Result};

/// The file's name; a finished report has none.
pub const UNFINISHED: &str = "unfinished.json";
/// Most of its bytes.
const MOST: u64 = 1 << 30;

/// Its content.
#[derive(Serialize, Deserialize)]
struct Unfinished {
    /// What is measured, where, and by which program.
    subject: Vec<(String, String)>,
    sections: Vec<Written>,
}

fn subject(bench: &Bench<'_>, sections: &[&Section]) -> Vec<(String, String)> {
    let names: Vec<&str> = sections.iter().map(|section| section.name).collect();
    let own = [
        ("commit", option_env!("MILKGLASS_COMMIT").unwrap_or_default().to_string()),
        ("sections", names.join(", ")),
        ("meshes", bench.meshes.join(", ")),
        ("history", mark(&bench.history)),
        ("day", mark(&bench.day)),
    ];
    setting::about(bench).into_iter().chain(own).map(|(key, value)| (key.to_string(), value)).collect()
}

/// A number that stands for what a file has.
fn mark(value: &impl Serialize) -> String {
    let mut hasher = DefaultHasher::new();
    serde_json::to_string(value).unwrap_or_default().hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// The file's bytes once these of the sections are written.
pub(super) fn bytes(bench: &Bench<'_>, sections: &[&Section], written: &[Written]) -> Vec<u8> {
    serde_json::json!({"subject": subject(bench, sections), "sections": written}).to_string().into_bytes()
}

/// The sections that an interrupted report in this folder has measured; an error if there is none, or it is not of the
/// same sections, device and program.
pub fn measured(folder: &Path, bench: &Bench<'_>, sections: &[&Section]) -> Result<Vec<Written>> {
    let path = folder.join(UNFINISHED);
    let fault = |what: String| Input::new(what).file(&path);
    let missing = |error| fault(format!("could not be read: {error}")).expected("the folder of an interrupted report");
    let known = std::fs::metadata(&path).map_err(missing)?;
    if !known.is_file() || known.len() > MOST {
        return Err(fault(format!("not a plain file of at most {MOST} bytes")).into());
    }
    let text = std::fs::read_to_string(&path).map_err(missing)?;
    let all: Unfinished = serde_json::from_str(&text)
        .map_err(|error| fault(format!("not an unfinished report: {error}")).line(error.line()))?;
    let own = subject(bench, sections);
    match own.iter().zip(&all.subject).find(|(own, old)| own != old) {
        None if own.len() == all.subject.len() => Ok(all.sections),
        None => {
            let fault =
                fault("of another version of this program".into()).found(format!("{} facts", all.subject.len()));
            Err(fault.expected(own.len()).into())
        }
        Some(((key, now), (_, old))) => {
            Err(fault("the interrupted report is another one".into()).key(key).found(old).expected(now).into())
        }
    }
}
