//! Runs the program in a temporary folder, for the tests of the command line.

#![allow(dead_code)] // each test program uses a part

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

pub fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The program in this folder; arguments are split at spaces.
pub fn program(folder: &TempDir, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_milkglass"));
    command.current_dir(folder.path()).args(line.split_whitespace()).env("MILKGLASS_VALIDATION", "0");
    command
}

pub fn said(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

/// Standard output and error of a run that must succeed.
pub fn good(folder: &TempDir, line: &str) -> (String, String) {
    let output = program(folder, line).output().unwrap();
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(0), "{line}\n{out}{err}");
    (out, err)
}

/// Must fail with this code and a message that contains all these words, and leave the folder's files as they were.
pub fn bad(folder: &TempDir, line: &str, code: i32, words: &[&str]) -> String {
    let before = names(folder.path());
    let output = program(folder, line).output().unwrap();
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(code), "{line}\n{out}{err}");
    assert!(err.starts_with("milkglass: ") || err.contains("\nmilkglass: "), "{line}: {err}");
    for word in words {
        assert!(err.contains(word), "{line}: no {word:?} in {err}");
    }
    assert!(!err.contains("panicked"), "{line}: {err}");
    assert_eq!(names(folder.path()), before, "{line} left something behind");
    err
}

pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

pub fn read(folder: &TempDir, name: &str) -> String {
    std::fs::read_to_string(folder.path().join(name)).unwrap()
}

pub fn bytes(folder: &TempDir, name: &str) -> Vec<u8> {
    std::fs::read(folder.path().join(name)).unwrap()
}

/// Header of a CSV file, and its rows as numbers.
pub fn numbers(text: &str) -> (String, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_string();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    (header, lines.map(row).collect())
}

pub fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * b.abs()
}
