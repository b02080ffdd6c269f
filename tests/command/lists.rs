//! The commands that list what is built in (stages, scenes, materials, devices), and the help of every command.

use crate::shell::{folder, good};

#[test]
fn every_stage_is_listed() {
    let here = folder(&[]);
    let text = good(&here, "stages").0;
    for stage in milkglass::internals::pipeline::frame::STAGES {
        let row = text.lines().find(|line| line.split_whitespace().next() == Some(stage.name));
        assert!(row.is_some_and(|row| row.contains(stage.about)), "{}", stage.name);
    }
}

#[test]
fn every_help_has_an_example() {
    let here = folder(&[]);
    for command in [
        "render",
        "gallery",
        "solve",
        "plan",
        "profile",
        "shader",
        "conform",
        "stress",
        "pareto",
        "eval",
        "devices",
        "scenes",
        "materials",
        "stages",
    ] {
        let (out, err) = good(&here, &format!("{command} --help"));
        assert!(out.contains(&format!("Example: milkglass {command}")), "{command}: {out}");
        assert!(err.is_empty(), "{command}: {err}");
    }
    assert!(good(&here, "--version").0.starts_with("milkglass "));
}

#[test]
fn lists_name_what_is_built_in() {
    let here = folder(&[]);
    for (list, name) in
        [("devices", "CPU reference"), ("materials", "Ketchup"), ("scenes", "lotus"), ("stages", "gather")]
    {
        assert!(good(&here, list).0.contains(name), "{list}");
    }
}
