//! Paths of every kind: pipes, links, devices, write-protected files, names that are no UTF-8.
#![cfg(unix)]

use std::process::{Command, Output};

use crate::shell::{bytes, folder, good, said};
use tempfile::TempDir;

const BALL: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const LINE: &str = "--device cpu --size 16x16 --samples 1";

/// A line of the shell, in which `$0` is the program and `$1` the rest of its arguments.
fn sh(here: &TempDir, line: &str) -> Output {
    let mut shell = Command::new("sh");
    let shell = shell.current_dir(here.path()).args(["-c", line, env!("CARGO_BIN_EXE_milkglass"), LINE]);
    shell.env("MILKGLASS_VALIDATION", "0").output().unwrap()
}

/// Such a line that must succeed; returns what it said.
fn well(here: &TempDir, line: &str) -> String {
    let output = sh(here, line);
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(0), "{line}\n{out}{err}");
    err
}

#[test]
fn a_mesh_from_a_pipe_stands_in_the_studio() {
    let here = folder(&[("a.obj", BALL)]);
    good(&here, &format!("render a.obj -o file.png {LINE}"));
    for line in [
        "cat a.obj | \"$0\" render /dev/stdin $1 -o pipe.png",
        "mkfifo p; cat a.obj > p & \"$0\" render p $1 -o pipe.png",
    ] {
        let told = well(&here, line);
        assert!(told.contains("key, fill and back light"), "{told}");
        assert!(bytes(&here, "pipe.png") == bytes(&here, "file.png"), "{line}");
    }
    // Commands that make no picture read a pipe, too.
    let output = sh(&here, "cat a.obj | \"$0\" scenes /dev/stdin; cat a.obj | \"$0\" plan /dev/stdin --device cpu");
    assert!(said(&output).0.contains("mesh = \"/dev/stdin\"") && output.status.success(), "{:?}", said(&output));
}

#[test]
fn links_stay_devices_are_written_and_protected_files_are_not() {
    let here = folder(&[("a.obj", BALL), ("old.png", "old")]);
    std::fs::create_dir(here.path().join("far")).unwrap();
    well(&here, "ln -s far/there.png here.png; \"$0\" render a.obj $1 -o here.png");
    assert!(here.path().join("here.png").is_symlink() && bytes(&here, "far/there.png").starts_with(b"\x89PNG"));
    let picture = sh(&here, "\"$0\" render a.obj $1 -o /dev/stdout").stdout;
    assert!(picture.starts_with(b"\x89PNG"));
    well(
        &here,
        "\"$0\" render a.obj $1 -o /dev/null && \"$0\" solve a.obj --device cpu -o /dev/null && test -c /dev/null",
    );
    let output = sh(&here, "chmod 444 old.png; \"$0\" render a.obj $1 -o old.png");
    let (_, err) = said(&output);
    assert!(err.contains("old.png: could not be written: it is write-protected"), "{err}");
    assert_eq!((output.status.code(), bytes(&here, "old.png")), (Some(2), b"old".to_vec()));
}

#[test]
fn names_need_not_be_utf_8() {
    let here = folder(&[("a.obj", BALL), ("s.toml", "[[object]]\nmesh = 'a.obj'\nmaterial.preset = 'marble'\n")]);
    well(
        &here,
        "n=$(printf 'caf\\351'); mkdir $n; cp a.obj $n/$n.obj; cp a.obj s.toml $n; \
         \"$0\" render $n/$n.obj $1 -o $n/$n.png && \"$0\" solve $n/s.toml --device cpu -o $n/$n.csv && \
         \"$0\" render $n/s.toml $1 --frames 0..1 -o $n/%d$n.png && \
         test -s $n/$n.png && test -s $n/$n.csv && test -s $n/1$n.png && \"$0\" scenes $n/$n.obj > /dev/null",
    );
    good(&here, &format!("render a.obj -o a.png {LINE}"));
    well(&here, "cmp a.png $(printf 'caf\\351/caf\\351.png')");
}
