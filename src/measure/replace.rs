//! Checks a user's replacements of our kernels: whether they run, and whether their values are right.

use std::collections::BTreeSet;

use super::conform::{Row, conform_stages};
use super::fixtures::Fixture;
use super::leaning::blame;
use crate::error::Result;
use crate::gpu::Device;
use crate::pipeline::frame::owner;
use crate::state::{Width, dispatches};

/// The stages of a device's replaced kernels.
pub fn stages(device: &Device) -> Vec<String> {
    let mut stages: Vec<String> = device.replaced().filter_map(|name| Some(owner(name)?.name.to_string())).collect();
    stages.sort();
    stages.dedup();
    stages
}

/// The names of the kernels that a fixture runs on a device.
pub fn kernels_of(fixture: &Fixture, device: &Device) -> Result<BTreeSet<String>> {
    let found = dispatches(&fixture.state, &fixture.steps, Width::of(device))?;
    Ok(found.into_iter().map(|dispatch| dispatch.kernel).collect())
}

/// Compares the stages of replaced kernels with the reference on these fixtures.
pub fn check(device: &Device, fixtures: &[Fixture]) -> Result<Vec<Row>> {
    let stages = stages(device);
    let rows = fixtures.iter().map(|fixture| conform_stages(device, fixture, &stages)).collect::<Result<Vec<_>>>()?;
    let mut rows: Vec<Row> = rows.into_iter().flatten().collect();
    blame(&mut rows);
    Ok(rows)
}
