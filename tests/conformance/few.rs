//! Every kernel against the CPU, on as few small fixtures as run them all.

use std::collections::BTreeSet;
use std::sync::Mutex;

use crate::devices::on_devices_each;
use milkglass::internals::gpu::sources;
use milkglass::internals::state::{Width, dispatches};
use milkglass::measure::conform::conform;
use milkglass::measure::fixtures::{EVERY_KERNEL, made};

#[test]
fn every_kernel_conforms() {
    let fixtures = made(|name| EVERY_KERNEL.contains(&name)).unwrap();
    assert_eq!(fixtures.len(), EVERY_KERNEL.len());
    let run: BTreeSet<String> = fixtures
        .iter()
        .flat_map(|fixture| dispatches(&fixture.state, &fixture.steps, Width { subgroup: 8, shares: false }).unwrap())
        .map(|dispatch| dispatch.kernel)
        .collect();
    for name in sources().filter(|name| !name.ends_with(".glsl") && !name.starts_with("measure/")) {
        assert!(run.contains(name), "no fixture of EVERY_KERNEL runs kernel {name}");
    }
    let faults = Mutex::new(Vec::new());
    on_devices_each(&fixtures, |device, fixture| {
        let rows = conform(device, fixture, &[]).unwrap();
        assert!(
            !rows.is_empty() && rows.iter().all(|row| row.distances.words > 0),
            "{} compared nothing",
            fixture.name
        );
        let named = rows
            .iter()
            .flat_map(|row| &row.faults)
            .map(|fault| format!("{}, {}: {fault}", device.name(), fixture.name));
        faults.lock().unwrap().extend(named);
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
