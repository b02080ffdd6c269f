//! Checks a user's replacement for one of our kernels: whether it runs, and whether its values are right.

use std::collections::BTreeSet;

use super::conform::{Row, conform_stages};
use super::fixtures::Fixture;
use super::leaning::blame;
use crate::error::{Input, Result};
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

/// An error for a replaced kernel that none of these fixtures runs, if there is one.
pub fn unused(device: &Device, fixtures: &[Fixture]) -> Result<Option<Input>> {
    let width = Width::of(device);
    let mut run = BTreeSet::new();
    for fixture in fixtures {
        run.extend(dispatches(&fixture.state, &fixture.steps, width)?.into_iter().map(|dispatch| dispatch.kernel));
    }
    let unused = device.replaced().find(|kernel| !run.contains(*kernel));
    Ok(unused.map(|kernel| {
        let what = match fixtures {
            [one] => format!("{} does not run this kernel", one.name),
            _ => "nothing that was chosen runs this kernel".into(),
        };
        let names = run.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        Input::new(what).key("--replace").found(kernel).expected(names)
    }))
}

/// Compares the stages of replaced kernels with the reference on these fixtures. Fails if one of the kernels is never
/// run.
pub fn check(device: &Device, fixtures: &[Fixture]) -> Result<Vec<Row>> {
    if let Some(fault) = unused(device, fixtures)? {
        return Err(fault.into());
    }
    let stages = stages(device);
    let rows = fixtures.iter().map(|fixture| conform_stages(device, fixture, &stages)).collect::<Result<Vec<_>>>()?;
    let mut rows: Vec<Row> = rows.into_iter().flatten().collect();
    blame(&mut rows);
    Ok(rows)
}
