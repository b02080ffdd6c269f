//! The commands of processes that compare on behalf of this one.

use std::path::Path;
use std::process::Command;

use super::arguments::Arguments;
use super::choose::Choice;
use crate::cli::watch::itself;
use milkglass::error::Result;

/// The command of a child on this device.
pub(super) fn command(arguments: &Arguments, device: usize) -> Result<Command> {
    let mut command = itself("conform")?;
    command.args(["--device", &device.to_string()]);
    if arguments.no_validation {
        command.arg("--no-validation");
    }
    command.args(arguments.replace.words());
    Ok(command)
}

/// Adds what to compare as arguments: the fixture or scene, these stages, and the folder for dumps.
pub(super) fn compares(
    command: &mut Command,
    arguments: &Arguments,
    choice: &Choice,
    (stages, dump): (&[String], Option<&Path>),
) {
    match choice {
        Choice::Fixture(name) => {
            command.args(["--fixture", name]);
        }
        Choice::Scene(name) => {
            command.arg(name).arg(format!("--frame={}", arguments.frame));
            command.args(arguments.sets.iter().flat_map(|set| ["--set", set]));
            command.args(arguments.option_args.words());
        }
    }
    if !stages.is_empty() {
        command.args(["--stage", &stages.join(",")]);
    }
    if let Some(folder) = dump {
        command.arg("--dump").arg(folder);
        if arguments.minimize {
            command.arg("--minimize");
        }
    }
    command.args(arguments.memory.words());
}
