//! Malformed and hostile input, at least thirty cases of each kind, run through the program: one clear message, exit
//! code 2, no files written, no panic, and bounded memory and time.

mod arguments;
mod formats;
mod images;
mod makers;
mod meshes;
mod scenes;
mod tables;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::shell::{folder, names};
use rayon::prelude::*;
use tempfile::TempDir;

/// Least number of cases per kind.
const FEWEST: usize = 30;
/// Address space of a run: 4,000,000 KiB, most of it never touched.
const MEMORY: &str = "ulimit -v 4000000; exec \"$0\" \"$@\"";
/// Time limit of a run.
const LONGEST: Duration = Duration::from_secs(60);

/// One run: files, a command line, and words that the message must contain.
pub struct Case {
    pub files: Vec<(String, Vec<u8>)>,
    pub line: Vec<String>,
    pub words: &'static str,
}

impl Case {
    pub fn new(files: &[(&str, &[u8])], line: &str, words: &'static str) -> Self {
        let files = files.iter().map(|(name, bytes)| ((*name).to_string(), bytes.to_vec())).collect();
        Self { files, line: line.split_whitespace().map(String::from).collect(), words }
    }

    /// What the program did wrong, if anything.
    fn fault(&self) -> Option<String> {
        let here = folder(&[]);
        for (name, bytes) in &self.files {
            std::fs::write(here.path().join(name), bytes).unwrap();
        }
        let before = names(here.path());
        let (code, message) = run(&here, &self.line);
        let one = message.lines().filter(|line| line.starts_with("milkglass: ")).count() == 1;
        let shape = message.contains("found ") || message.contains("expected ") || message.contains(": ");
        let fine = code == Some(2)
            && one
            && shape
            && message.contains(self.words)
            && !message.contains("panicked")
            && names(here.path()) == before;
        (!fine).then(|| format!("{:?}, wants {:?}: code {code:?}: {}", self.line, self.words, message.trim_end()))
    }
}

/// Exit code and standard error; no code if the run exceeded the time limit.
fn run(here: &TempDir, line: &[String]) -> (Option<i32>, String) {
    let mut command = Command::new("sh");
    command.args(["-c", MEMORY, env!("CARGO_BIN_EXE_milkglass")]).args(line).current_dir(here.path());
    let said = here.path().join("../").join(format!("{}.said", here.path().file_name().unwrap().to_string_lossy()));
    let file = std::fs::File::create(&said).unwrap();
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file).spawn().unwrap();
    let start = Instant::now();
    let code = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status.code(),
            None if start.elapsed() > LONGEST => {
                child.kill().unwrap();
                child.wait().unwrap();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let text = String::from_utf8_lossy(&std::fs::read(&said).unwrap()).into_owned();
    std::fs::remove_file(&said).unwrap();
    (code, text)
}

/// Checks all cases of a kind.
fn refused(cases: &[Case]) {
    assert!(cases.len() >= FEWEST, "{} cases", cases.len());
    let faults: Vec<String> =
        cases.par_iter().enumerate().filter_map(|(k, case)| Some(format!("{k}: {}", case.fault()?))).collect();
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), cases.len(), faults.join("\n"));
}

#[test]
fn scenes() {
    refused(&scenes::cases());
}

#[test]
fn meshes() {
    refused(&meshes::cases());
}

#[test]
fn ply_and_stl() {
    refused(&formats::ply_and_stl());
}

#[test]
fn gltf() {
    refused(&formats::gltf());
}

#[test]
fn libraries() {
    refused(&meshes::libraries());
}

#[test]
fn png() {
    refused(&images::png());
}

#[test]
fn exr() {
    refused(&images::exr());
}

#[test]
fn hdr() {
    refused(&images::hdr());
}

#[test]
fn tables() {
    refused(&tables::cases());
}

#[test]
fn arguments() {
    refused(&arguments::cases());
}
