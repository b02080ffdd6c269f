//! `milkglass report`: all measurements on one page.

use std::path::PathBuf;

use clap::Args;

use super::profile::timed_again;
use super::{DeviceArgument, compile, print, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::measure::folder::{Folder, REPORT};
use milkglass::measure::profile::history::read;
use milkglass::measure::report::{Bench, Day, PARTS, SECTIONS, Section, report};

/// Arguments of `report`.
#[derive(Args)]
#[command(after_help = "Example: milkglass report -o report --quick\n         \
                        milkglass report -o layers --only pictures,layers --device cpu\n\n\
                        DIR must be new, empty, or hold an earlier report, whose files of the same names are replaced, each as soon as it \
                        is measured: what a stopped run has measured stays.")]
pub struct Arguments {
    #[command(flatten)]
    device: DeviceArgument,
    /// The folder for index.html and the CSV files.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Small scenes and few settings: takes minutes.
    #[arg(long)]
    quick: bool,
    /// Mesh files that the tables of Mertens et al. are measured for, too.
    meshes: Vec<String>,
    /// Only these sections, or tables and figures of the papers, such as `mertens/table5`, separated by commas
    /// [default: all sections].
    #[arg(long, value_name = "SECTIONS", value_delimiter = ',')]
    only: Vec<String>,
    /// Also draw the runs that `profile --history` wrote to this file, in section `history`.
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// Also show what `bench/device-day` found on another device, whose folder this is, beside the same on this one, in
    /// section `day`; without `--only` this is the only section.
    #[arg(long, value_name = "DAY")]
    from: Option<PathBuf>,
}

/// Measures and writes the page; fails if a section does.
pub fn run(arguments: &Arguments) -> Result<()> {
    for name in &arguments.only {
        if !SECTIONS.iter().chain(PARTS).any(|section| section.name == name) {
            let names: Vec<_> = SECTIONS.iter().chain(PARTS).map(|section| section.name).collect();
            return Err(Input::new("no such section").key("--only").found(name).expected(names.join(", ")).into());
        }
    }
    let lacks = |name: &str| match name {
        "history" if arguments.history.is_none() => Some("--history FILE"),
        "day" if arguments.from.is_none() => Some("--from DAY"),
        _ => None,
    };
    let drawn = |name: &str| lacks(name).is_none();
    if let Some((name, lack)) = arguments.only.iter().find_map(|name| Some((name, lacks(name)?))) {
        let fault = Input::new("this section shows what a file has").key("--only").found(name);
        return Err(fault.expected(lack).into());
    }
    let day = arguments.from.as_deref().map(Day::read).transpose()?;
    let alone = arguments.only.is_empty() && day.is_some();
    let asked =
        |section: &&Section| arguments.only.iter().any(|name| name == section.name) || (alone && section.name == "day");
    let sections: Vec<&Section> = match arguments.only.is_empty() && !alone {
        true => SECTIONS.iter().filter(|section| drawn(section.name)).collect(),
        false => SECTIONS.iter().chain(PARTS).filter(asked).collect(),
    };
    if !arguments.meshes.is_empty() && !sections.iter().any(|section| section.name.starts_with("mertens")) {
        let fault = Input::new("only tables of Mertens et al. are measured for meshes").found(&arguments.meshes[0]);
        return Err(fault.expected("--only mertens/table5, for example").into());
    }
    let history = arguments.history.as_deref().map(read).transpose()?;
    let folder = Folder::open(&arguments.output, &REPORT, "-o")?;
    let device = arguments.device.open(validation())?;
    let begun = format!("<!doctype html>\n<meta name=\"generator\" {}>\n<p>No section is finished.</p>\n", REPORT.mark);
    let keep = |name: &str, bytes: &[u8]| folder.put(name, bytes, &begun);
    let bench = Bench {
        device: device.as_ref(),
        quick: arguments.quick,
        keep: Some(&keep),
        meshes: &arguments.meshes,
        history: history.as_deref(),
        day: day.as_ref(),
        timed: Some(&timed_again),
        compilers: Some(&compile::tables),
    };
    let mut number = 0;
    let mut tell = |name: &str| {
        number += 1;
        tell!("{number}/{} {name}", sections.len());
    };
    let made = report(&bench, &sections, &mut tell)?;
    print(&format!("{}\n", arguments.output.join(REPORT.page).display()))?;
    if made.faults.is_empty() {
        return Ok(());
    }
    Err(Error::Check(format!("the report has {} failures:\n{}", made.faults.len(), made.faults.join("\n"))))
}
