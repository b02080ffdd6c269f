//! What an interrupted report has measured, so that another run can go on with it: a file beside the page.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Bench, Section, Written, setting};
use crate::error::{Input, Result};
use crate::measure::tables::mesh;
use crate::measure::tables::paper::EXTENT_4;
use crate::scene::Object;

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

/// What is measured: of meshes and files, their content now.
pub(super) fn subject(bench: &Bench<'_>, sections: &[&Section]) -> Vec<(String, String)> {
    let names: Vec<&str> = sections.iter().map(|section| section.name).collect();
    let own = [
        ("commit", option_env!("MILKGLASS_COMMIT").unwrap_or_default().to_string()),
        ("sections", names.join(", ")),
        (
            "meshes",
            bench.meshes.iter().map(|path| format!("{path} ({})", content(path))).collect::<Vec<_>>().join(", "),
        ),
        ("history", mark(&bench.history)),
        ("day", mark(&bench.day)),
    ];
    setting::about(bench).into_iter().chain(own).map(|(key, value)| (key.to_string(), value)).collect()
}

/// A number that stands for a mesh: its vertices and triangles, whichever files they are in.
fn content(path: &str) -> String {
    let Ok(scene) = mesh(path, EXTENT_4) else { return "not readable".into() };
    let bits = |object: &Object| -> Vec<[u64; 3]> {
        object.mesh.positions.iter().map(|place| place.to_array().map(f64::to_bits)).collect()
    };
    mark(&scene.objects.iter().map(|object| (bits(object), &object.mesh.triangles)).collect::<Vec<_>>())
}

/// A number that stands for what a file has.
fn mark(value: &impl Serialize) -> String {
    let mut hasher = DefaultHasher::new();
    serde_json::to_string(value).unwrap_or_default().hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// The file's bytes once these sections of a report on this subject are written.
pub(super) fn bytes(subject: &[(String, String)], written: &[Written]) -> Vec<u8> {
    serde_json::json!({"subject": subject, "sections": written}).to_string().into_bytes()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_mesh_is_another_report() {
        let here = tempfile::tempdir().unwrap();
        let file = here.path().join("one.obj");
        let own = [file.to_string_lossy().into_owned()];
        let with = |corner: &str| {
            std::fs::write(&file, format!("v 0 0 0\nv 1 0 0\n{corner}\nf 1 2 3\n")).unwrap();
            subject(&Bench { meshes: &own, ..Bench::default() }, &[])
        };
        let first = with("v 0 1 0");
        assert_eq!(first, with("v 0 1 0"));
        let other = with("v 0 1 1");
        let keys: Vec<&String> = first.iter().zip(&other).filter(|(a, b)| a != b).map(|((key, _), _)| key).collect();
        assert_eq!(keys, ["meshes"]);
    }
}
