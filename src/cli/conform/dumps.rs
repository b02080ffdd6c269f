//! `--dump`: what differs, as files that repeat it elsewhere.

use std::path::Path;

use crate::cli::repro::written;
use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::measure::conform::Row;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::repro::trace::{case, first_step};

/// Writes a folder for each of these rows, and says what it holds.
pub(super) fn write<'a>(
    (folder, least): (&Path, bool),
    fixture: &Fixture,
    device: &Device,
    rows: impl Iterator<Item = &'a Row>,
) -> Result<()> {
    for row in rows {
        // Where only the mean is off, no step is beyond tolerance: the first one.
        let lanes = device.limits().subgroup_size.max(1) as usize;
        let step = row.failed.map_or_else(|| first_step(fixture, row.stage, lanes), |step| Ok(Some(step)))?;
        let Some(case) = step.map(|step| case(device, fixture, step)).transpose()?.flatten() else { continue };
        let own = folder.join(name(device, row));
        std::fs::create_dir_all(folder)
            .map_err(|error| milkglass::error::Input::new(format!("could not be written: {error}")).file(folder))?;
        tell!("{}", written(&case, device, &own, "--dump", least)?.trim_end());
        if row.failed.is_some() && !case.about.fails {
            tell!("{}: it does not fail again; a race may do so in many runs: replay --times 1000", own.display());
        }
    }
    Ok(())
}

/// A folder's name: stage, fixture and device.
fn name(device: &Device, row: &Row) -> String {
    let plain = |text: &str| -> String {
        let dashed: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        dashed.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
    };
    let device = plain(device.name().split(['(', ',']).next().unwrap_or_default());
    format!("{}-{}-{device}", row.stage, plain(row.fixture.rsplit('/').next().unwrap_or(&row.fixture)))
}
