//! `--dump`: a comparison that fails, as files that repeat it elsewhere.

use std::path::Path;

use crate::cli::repro::written;
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::measure::conform::Row;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::repro::trace::{case, first_step};

/// Writes a folder for this row, and says what it holds.
pub(super) fn write((folder, least): (&Path, bool), fixture: &Fixture, device: &Device, row: &Row) -> Result<()> {
    // Where only the mean is off, no step is beyond tolerance: take the first one.
    let step = row.failed.map_or_else(|| first_step(fixture, row.stage, device), |step| Ok(Some(step)))?;
    let Some(case) = step.map(|step| case(device, fixture, step)).transpose()?.flatten() else { return Ok(()) };
    made(folder)?;
    let own = folder.join(name(row.stage, &row.fixture, device.name()));
    tell!("{}", written(&case, device, &own, "--dump", least)?.trim_end());
    if row.failed.is_some() && !case.about.fails {
        tell!("{}: it does not fail again; a race may fail in one of many runs: replay --times 1000", own.display());
    }
    Ok(())
}

/// Makes this folder.
pub(super) fn made(folder: &Path) -> Result<()> {
    let fault = |error: std::io::Error| Input::new(format!("could not be written: {error}")).file(folder);
    Ok(std::fs::create_dir_all(folder).map_err(fault)?)
}

/// A folder's name: stage, fixture and device.
pub(super) fn name(stage: &str, fixture: &str, device: &str) -> String {
    let plain = |text: &str| -> String {
        let dashed: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        dashed.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
    };
    format!("{stage}-{}-{}", plain(fixture.rsplit('/').next().unwrap_or(fixture)), plain(device))
}
