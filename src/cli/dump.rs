//! `milkglass dump`: a stage of a fixture as files that repeat it elsewhere.

use std::path::PathBuf;

use clap::Args;

use super::print;
use super::replace::{ReplaceArgument, replaced};
use super::repro::{Chosen, written};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::pipeline::frame::{STAGES, stage};
use milkglass::measure::fixtures::{Fixture, fixture};
use milkglass::measure::repro::trace::{case, first_step};

/// Arguments of `dump`.
#[derive(Args)]
#[command(
    after_help = "Example: milkglass dump push --fixture sliver -o push-sliver\n         milkglass replay push-sliver"
)]
pub struct Arguments {
    /// The stage; `milkglass stages` lists them.
    stage: String,
    /// The fixture; `milkglass conform --list` lists them.
    #[arg(long, value_name = "NAME")]
    fixture: String,
    /// The folder to write: new, empty, or of an earlier dump.
    #[arg(short, value_name = "FOLDER")]
    output: PathBuf,
    /// Leave out groups that do not fail, and the ends of buffers that nothing reaches.
    #[arg(long)]
    minimize: bool,
    #[command(flatten)]
    device: Chosen,
    #[command(flatten)]
    replace: ReplaceArgument,
}

/// Runs the stage and writes the files.
pub fn run(arguments: &Arguments) -> Result<()> {
    let Some(stage) = stage(&arguments.stage) else {
        let names: Vec<_> = STAGES.iter().map(|stage| stage.name).collect();
        let fault = Input::new("there is no such stage").found(&arguments.stage);
        return Err(fault.expected(names.join(", ")).into());
    };
    let kernels = arguments.replace.load()?;
    let fixture: Fixture = fixture(&arguments.fixture)?;
    let device = replaced(&arguments.device.open()?, &kernels)?;
    let index = first_step(&fixture, stage.name, &device)?;
    let made = index.map(|index| case(&device, &fixture, index)).transpose()?.flatten();
    let Some(case) = made else {
        let fault = Input::new(format!("{} does not run this stage", fixture.name)).found(stage.name);
        let runs: std::collections::BTreeSet<_> = fixture.steps.iter().map(|step| step.stage.name).collect();
        return Err(fault.expected(runs.into_iter().collect::<Vec<_>>().join(", ")).into());
    };
    print(&written(&case, &device, &arguments.output, "-o", arguments.minimize)?)?;
    match device.take_messages().as_slice() {
        [] => Ok(()),
        [first, ..] => Err(Error::Check(format!("the validation layer says: {first}"))),
    }
}
