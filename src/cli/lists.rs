//! `milkglass scenes`, `materials` and `stages`: lists of what is built in.

use clap::Args;

use super::{flow, print, table};
use milkglass::Scene;
use milkglass::error::{Input, Result};
use milkglass::internals::pipeline::frame::{FRAME, Part, QUERIES};
use milkglass::internals::state::{Change, Stage, Update};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::table::{Column, Table};
use milkglass::scene::{BUILTIN, Files, Preset, Studio, Wishes};
use std::path::{Path, PathBuf};

/// Arguments of `scenes`.
#[derive(Args)]
#[command(after_help = "Example: milkglass scenes lotus > mine.toml")]
pub struct Scenes {
    /// Print this scene's TOML file, to copy and edit; for a mesh alone, the studio in which `render` shows it.
    #[arg(value_parser = super::paths::any_path())]
    name: Option<String>,
}

/// Arguments of `materials`: none.
#[derive(Args)]
#[command(after_help = "Example: milkglass materials")]
pub struct Materials {}

/// Arguments of `stages`.
#[derive(Args)]
#[command(after_help = "Example: milkglass stages --flow stages.svg")]
pub struct Stages {
    /// Also draw which buffers each stage reads and writes.
    #[arg(long, value_name = "FILE.svg")]
    flow: Option<PathBuf>,
}

/// Lists the built-in scenes, or prints one.
pub fn scenes(arguments: &Scenes) -> Result<()> {
    let Some(name) = &arguments.name else {
        let rows: Vec<_> = BUILTIN.iter().map(|(name, _, about)| vec![name.to_string(), about.to_string()]).collect();
        print(&table(["scene", "what it shows"], rows))?;
        return Ok(());
    };
    match BUILTIN.iter().find(|(known, _, _)| known.eq_ignore_ascii_case(name)) {
        Some((_, text, _)) => {
            print(text)?;
            Ok(())
        }
        None if Files::default().exists(Path::new(name)) && !Path::new(name).is_dir() => {
            let (mut text, animations) = Scene::text(name, &Files::default())?;
            // A mesh alone: the scene that `render` makes of it.
            if let Some(studio) = Studio::around(name, &[], 0.0, &Files::default(), Wishes::default())? {
                studio.told.iter().for_each(|line| tell!("{line}"));
                text = studio.toml();
            }
            let line = |(name, seconds): &(String, f64)| format!("# --animation {name:?}: {seconds:.3} s\n");
            print(&format!("{}{text}", animations.iter().map(line).collect::<String>()))
        }
        None => {
            let known: Vec<_> = BUILTIN.iter().map(|(name, _, _)| *name).collect();
            Err(Input::new("neither a built-in scene nor a file has this name")
                .found(name)
                .expected(format!("a file, or one of {}", known.join(", ")))
                .into())
        }
    }
}

/// Lists the stages in the order of a frame, under its headings.
pub fn stages(arguments: &Stages) -> Result<()> {
    ready([("--flow", arguments.flow.as_ref())])?;
    if let Some(file) = &arguments.flow {
        flow::write(file, &|_| true)?;
    }
    let mut text = String::new();
    let header = ["stage", "module", "runs again for another", "does", "from"];
    for section in FRAME {
        text += &format!("{}\n", section.title);
        let rows: Vec<_> = section.parts.iter().flat_map(rows).collect();
        text += &format!("{}\n", table(header, rows));
    }
    text += "No part of a frame: what `milkglass eval` answers\n";
    text += &table(header, QUERIES.iter().map(|stage| row(stage)).collect());
    print(&text)
}

fn rows(part: &Part) -> Vec<Vec<String>> {
    match part {
        Part::Loop(_, stages) => stages.iter().map(|stage| row(stage)).collect(),
        Part::Host(host) => {
            vec![[host.name, "on the host", "shape, light", host.about, host.equation].map(String::from).to_vec()]
        }
    }
}

fn row(stage: &Stage) -> Vec<String> {
    let changes = [("shape", Change::EVERYTHING), ("light", Change::LIGHT), ("view", Change::VIEW)];
    let again = |change: &&(&str, Change)| (stage.runs)(&Update { change: change.1, ..Update::default() });
    let again: Vec<&str> = changes.iter().filter(again).map(|(name, _)| *name).collect();
    [stage.name, stage.module, &again.join(", "), stage.about, stage.equation].map(String::from).to_vec()
}

/// Lists the presets, measured ones and looks.
pub fn materials(_: &Materials) -> Result<()> {
    let three = |v: [f64; 3]| v.map(|x| x.to_string()).join(" ");
    let columns: [Column<'_, &Preset>; 6] = [
        ("material", "", &|m| m.name.into()),
        ("sigma_s' per mm (r g b)", "", &|m| three(m.sigma_s_prime)),
        ("sigma_a per mm (r g b)", "", &|m| three(m.sigma_a)),
        ("eta", "", &|m| m.eta.to_string()),
        ("coefficients", "", &|m| m.origin.words().into()),
        ("diffuse reflectance as printed", "", &|m| m.diffuse_reflectance.map_or_else(String::new, three)),
    ];
    print(&Table::of(&Preset::all().collect::<Vec<_>>(), &columns).text())
}
