//! A kernel of the user's in the place of one of ours: does it run at all here, and are its values right?

use super::conform::{Row, conform_stages};
use super::fixtures::Fixture;
use crate::error::{Input, Result};
use crate::gpu::Device;
use crate::state::dispatches;

/// The stages that a device's replaced kernels belong to.
pub fn stages(device: &Device) -> Vec<String> {
    let mut stages: Vec<String> =
        device.replaced().filter_map(|name| name.split('/').nth(1)).map(String::from).collect();
    stages.dedup();
    stages
}

/// Compares the stages of replaced kernels with the reference on this fixture; an error where it runs one of them nowhere.
pub fn check(device: &Device, fixture: &Fixture) -> Result<Vec<Row>> {
    let lanes = device.limits().subgroup_size.max(1) as usize;
    let list = dispatches(&fixture.state, &fixture.steps, lanes)?;
    for kernel in device.replaced() {
        if !list.iter().any(|dispatch| dispatch.kernel == kernel) {
            let mut names: Vec<_> = list.iter().map(|dispatch| dispatch.kernel.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            let fault = Input::new(format!("{} does not run this kernel", fixture.name)).key("--replace").found(kernel);
            return Err(fault.expected(names.join(", ")).into());
        }
    }
    conform_stages(device, fixture, &stages(device))
}
