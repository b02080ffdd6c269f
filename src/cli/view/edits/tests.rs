//! Nothing that was done in the window is lost to a mistake in the scene's file.

use clap::Parser;

use super::*;
use crate::cli::render::PictureArguments;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    picture: PictureArguments,
}

const SCENE: &str = include_str!("../../../scene/builtin/slab.toml");

/// A scene with two changes of its tolerance, 0.01 and 0.02, and its file.
fn edited() -> (tempfile::TempDir, PathBuf, Edits) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("slab.toml");
    std::fs::write(&file, SCENE).unwrap();
    let line = Line::try_parse_from(["view", file.to_str().unwrap()]).unwrap_or_else(|error| panic!("{error}"));
    let mut edits = Edits::of(line.picture.subject().unwrap()).unwrap();
    for tolerance in [0.01, 0.02] {
        edits.begin();
        let set = |scene: &mut Scene| scene.transport.tolerance = tolerance;
        edits.adjust("transport.tolerance", tolerance.to_string(), set);
    }
    (folder, file, edits)
}

const LAST: [&str; 2] = ["--set", "transport.tolerance=0.02"];

#[test]
fn a_broken_file_costs_no_changes() {
    let (_folder, file, mut edits) = edited();
    std::fs::write(&file, "[camera").unwrap();
    assert!(edits.settle().is_err() && edits.arguments() == LAST);
    assert!(edits.settle().is_ok(), "it is told once");
    for _ in 0..2 {
        assert!(edits.undo().is_err() && edits.reset().is_err() && edits.arguments() == LAST);
    }
    std::fs::write(&file, SCENE).unwrap();
    assert!(edits.undo().unwrap() && edits.arguments() == ["--set", "transport.tolerance=0.01"]);
    assert!(edits.undo().unwrap() && edits.arguments().is_empty() && !edits.undo().unwrap());
    std::fs::write(&file, "[camera").unwrap();
    assert!(edits.redo().is_err() && edits.arguments().is_empty());
    std::fs::write(&file, SCENE).unwrap();
    assert!(edits.redo().unwrap() && edits.redo().unwrap() && edits.arguments() == LAST);
    assert!(!edits.redo().unwrap() && edits.scene.transport.tolerance == 0.02);
}

#[test]
fn a_change_that_can_not_be_read_is_taken_back() {
    let (_folder, _, mut edits) = edited();
    edits.settle().unwrap();
    edits.begin();
    edits.adjust("transport.tolerance", "-1".to_owned(), |scene| scene.transport.tolerance = -1.0);
    assert!(edits.settle().is_err() && edits.arguments() == LAST && edits.scene.transport.tolerance == 0.02);
    assert!(edits.undo().unwrap() && edits.scene.transport.tolerance == 0.01);
}

#[test]
fn what_changes_nothing_leaves_redo() {
    let (_folder, _, mut edits) = edited();
    edits.undo().unwrap();
    edits.begin();
    assert!(edits.redo().unwrap() && edits.arguments() == LAST);
    edits.undo().unwrap();
    edits.begin();
    edits.set("transport.tolerance", "0.5".to_owned()).unwrap();
    assert!(!edits.redo().unwrap(), "another change was made since");
    // A scene that can be drafted, but not rendered, goes with its settings.
    let before = edits.state();
    edits.set("transport.tolerance", "0.25".to_owned()).unwrap();
    edits.restore(before).unwrap();
    assert_eq!((edits.scene.transport.tolerance, edits.arguments()[1].as_str()), (0.5, "transport.tolerance=0.5"));
}
