//! The commands that list what is built in (stages, scenes, materials, devices), and the help of every command.

use crate::shell::{bad, folder, good, read};

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
fn the_flow_of_data_is_drawn() {
    let here = folder(&[]);
    good(&here, "stages --flow all.svg");
    let drawn = read(&here, "all.svg");
    for stage in milkglass::internals::pipeline::frame::parts().flat_map(|part| part.stages()) {
        assert!(drawn.contains(&format!(">{}<title>", stage.name)), "{}", stage.name);
    }
    // `gather` sums over the lists that `link` writes.
    let title =
        |stage: &str| drawn.split(&format!(">{stage}<title>")).nth(1).unwrap().split("</title>").next().unwrap();
    let list = |stage: &str, word: &str| {
        let line = title(stage).lines().find_map(|line| line.strip_prefix(word)).unwrap().to_string();
        line.split(',').map(|name| name.trim().to_string()).collect::<Vec<_>>()
    };
    assert!(list("link", "writes").contains(&"entries".to_string()), "{}", title("link"));
    assert!(list("gather", "reads").contains(&"entries".to_string()), "{}", title("gather"));
    assert!(list("octree", "writes").contains(&"radiosity".to_string()), "{}", title("octree"));
    // A plan greys out what a scene does without.
    good(&here, "plan sphere --device cpu --set object.0.detail=1 --flow sphere.svg");
    let sphere = read(&here, "sphere.svg");
    let grey = |stage: &str| {
        let line = sphere.lines().find(|line| line.contains(&format!(">{stage}<title>"))).unwrap();
        line.contains("#b0b0b0")
    };
    assert!(grey("relief") && grey("octree") && !grey("gather"));
    bad(&here, "stages --flow nowhere/all.svg", 2, &["nowhere/all.svg", "could not be written"]);
}

/// The names of all commands, as the help lists them.
fn commands() -> Vec<String> {
    let help = good(&folder(&[]), "--help").0;
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = lines.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    let names: Vec<String> = names.map(str::to_string).collect();
    assert!(names.len() > 20 && names.contains(&"render".to_string()), "{names:?}");
    names
}

#[test]
fn shells_and_manuals_know_every_command() {
    let here = folder(&[]);
    let page = good(&here, "man").0;
    assert!(page.contains(".TH milkglass 1"), "{page}");
    good(&here, "man -o .");
    let scripts: Vec<String> =
        ["bash", "zsh", "fish"].map(|shell| good(&here, &format!("completions {shell}")).0).into();
    for command in commands() {
        assert!(page.contains(&format!("milkglass\\-{}(1)", command.replace('-', "\\-"))), "{command}: {page}");
        let own = std::fs::read_to_string(here.path().join(format!("milkglass-{command}.1"))).unwrap();
        assert!(own.contains("Example: milkglass"), "{command}: {own}");
        assert!(scripts.iter().all(|script| script.contains(&command)), "{command}");
    }
    bad(&here, "man -o nowhere", 2, &["-o", "nowhere", "a folder"]);
    bad(&here, "completions cmd", 2, &["cmd", "bash, "]);
}

#[test]
fn every_help_has_an_example() {
    let here = folder(&[]);
    for command in commands() {
        let (out, err) = good(&here, &format!("{command} --help"));
        let example = out.split("Example: milkglass ").nth(1);
        assert!(example.is_some_and(|text| text.contains(&command)), "{command}: {out}");
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
