//! `milkglass report`: all measurements on one page.

use std::path::PathBuf;

use clap::Args;

use super::profile::timed_again;
use super::{DeviceArgument, compile, print, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::measure::folder::{Folder, REPORT};
use milkglass::measure::profile::history::{Entry, read};
use milkglass::measure::report::{Bench, Day, PARTS, SECTIONS, Section, UNFINISHED, measured, report};
use milkglass::measure::tables::mesh;
use milkglass::measure::tables::paper::EXTENT_4;

/// Arguments of `report`.
#[derive(Args)]
#[command(after_help = "Example: milkglass report -o report --quick\n         \
                        milkglass report -o layers --only pictures,layers --device cpu\n\n\
                        DIR must be new, empty, or hold an earlier report, whose files of the same names are replaced, each as soon as it \
                        is measured: what a stopped run has measured stays, and the same command with --resume goes on.")]
pub struct Arguments {
    #[command(flatten)]
    device: DeviceArgument,
    /// The folder for index.html and the CSV files.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Go on with the interrupted report in DIR: the sections that it has are not measured again.
    #[arg(long)]
    resume: bool,
    /// Small scenes and few settings: takes minutes.
    #[arg(long)]
    quick: bool,
    /// Mesh files that tables 4 and 5 of Mertens et al. and figure 2 of Kubo et al. are measured for, too.
    meshes: Vec<String>,
    /// Only these sections, or tables and figures of the papers, such as `mertens/table5`, separated by commas
    /// [default: all sections].
    #[arg(long, value_name = "SECTIONS", value_delimiter = ',')]
    only: Vec<String>,
    /// Draw the runs that `profile --history` wrote to this file, in section `history`.
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// Show what `bench/device-day` found on another device, whose folder this is, beside the same on this one, in
    /// section `day`; without `--only` this is the only section.
    #[arg(long, value_name = "DAY")]
    from: Option<PathBuf>,
}

/// The sections that are asked for.
fn chosen(arguments: &Arguments) -> Result<Vec<&'static Section>> {
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
    let alone = arguments.only.is_empty() && arguments.from.is_some();
    let asked =
        |section: &&Section| arguments.only.iter().any(|name| name == section.name) || (alone && section.name == "day");
    Ok(match arguments.only.is_empty() && !alone {
        true => SECTIONS.iter().filter(|section| drawn(section.name)).collect(),
        false => SECTIONS.iter().chain(PARTS).filter(asked).collect(),
    })
}

/// Reads the files that these sections take; an error for one that none of them takes.
fn inputs(arguments: &Arguments, sections: &[&Section]) -> Result<(Option<Vec<Entry>>, Option<Day>)> {
    let has = |name: &str| sections.iter().any(|section| section.name == name);
    for (key, section, path) in [("--history", "history", &arguments.history), ("--from", "day", &arguments.from)] {
        if let (Some(path), false) = (path, has(section)) {
            let fault = Input::new("no section shows this").key(key).found(path.display());
            return Err(fault.expected(format!("--only {section}")).into());
        }
    }
    let some = ["mertens/table4", "mertens/table5", "kubo/figure2"];
    let measured = some.into_iter().any(has) || (has("mertens") || has("kubo")) && !arguments.quick;
    if let (Some(first), false) = (arguments.meshes.first(), measured) {
        let fault = Input::new("no section measures meshes").found(first);
        return Err(fault
            .expected("--only mertens/table4, mertens/table5, kubo/figure2, or mertens or kubo without --quick")
            .into());
    }
    // They are read again when they are measured, minutes later.
    arguments.meshes.iter().try_for_each(|path| mesh(path, EXTENT_4).map(drop))?;
    let history = arguments.history.as_deref().map(read).transpose()?;
    Ok((history, arguments.from.as_deref().map(Day::read).transpose()?))
}

/// Measures and writes the page; fails if a section does.
pub fn run(arguments: &Arguments) -> Result<()> {
    let sections = chosen(arguments)?;
    let (history, day) = inputs(arguments, &sections)?;
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
    let earlier = match arguments.resume {
        true => measured(&arguments.output, &bench, &sections)?,
        // What an earlier one has measured must not be taken for a part of this one.
        false => folder.remove(UNFINISHED).map(|()| Vec::new())?,
    };
    let count = sections.len();
    let mut tell = |name: &str| {
        let place = sections.iter().position(|section| section.name == name).unwrap_or_default();
        tell!("{}/{count} {name}", place + 1);
    };
    let made = report(&bench, &sections, earlier, &mut tell)?;
    folder.remove(UNFINISHED)?;
    print(&format!("{}\n", arguments.output.join(REPORT.page).display()))?;
    if made.faults.is_empty() {
        return Ok(());
    }
    Err(Error::Check(format!("the report has {} failures:\n{}", made.faults.len(), made.faults.join("\n"))))
}
