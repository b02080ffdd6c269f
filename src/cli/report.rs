//! `milkglass report`: all measurements on one page.

use std::path::PathBuf;

use clap::Args;

use super::{DeviceArgument, compile, print, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::measure::folder::{Folder, REPORT};
use milkglass::measure::profile::history::read;
use milkglass::measure::report::{Bench, SECTIONS, Section, report};

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
    /// Only these sections, separated by commas [default: all].
    #[arg(long, value_name = "SECTIONS", value_delimiter = ',')]
    only: Vec<String>,
    /// Also draw the runs that `profile --history` wrote to this file, in section `history`.
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
}

/// Measures and writes the page; fails if a section does.
pub fn run(arguments: &Arguments) -> Result<()> {
    for name in &arguments.only {
        if !SECTIONS.iter().any(|section| section.name == name) {
            let names: Vec<_> = SECTIONS.iter().map(|section| section.name).collect();
            return Err(Input::new("no such section").key("--only").found(name).expected(names.join(", ")).into());
        }
    }
    let drawn = |name: &str| name != "history" || arguments.history.is_some();
    if let Some(name) = arguments.only.iter().find(|name| !drawn(name)) {
        let fault = Input::new("there are no runs to draw").key("--only").found(name);
        return Err(fault.expected("--history FILE").into());
    }
    let wanted = |section: &&Section| {
        drawn(section.name) && (arguments.only.is_empty() || arguments.only.iter().any(|n| n == section.name))
    };
    let sections: Vec<&Section> = SECTIONS.iter().filter(wanted).collect();
    let history = arguments.history.as_deref().map(read).transpose()?;
    let folder = Folder::open(&arguments.output, &REPORT, "-o")?;
    let device = arguments.device.open(validation())?;
    let begun = format!("<!doctype html>\n<meta name=\"generator\" {}>\n<p>No section is finished.</p>\n", REPORT.mark);
    let keep = |name: &str, bytes: &[u8]| folder.put(name, bytes, &begun);
    let bench = Bench {
        device: device.as_ref(),
        quick: arguments.quick,
        keep: Some(&keep),
        history: history.as_deref(),
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
