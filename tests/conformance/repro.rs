//! Every stage of some fixtures as a case: from the files alone a device does again what it did.

use std::collections::BTreeSet;

use crate::devices::on_devices;
use milkglass::internals::pipeline::frame::STAGES;
use milkglass::measure::fixtures::{Fixture, fixture};
use milkglass::measure::repro::minimize::minimize;
use milkglass::measure::repro::trace::{case, first_step};
use milkglass::measure::repro::{Case, Part};

/// Checks the case of each stage of this fixture, except those that are done.
fn all(fixture: &Fixture, done: &mut BTreeSet<&'static str>, check: impl Fn(&Case)) {
    on_devices(|device| {
        for stage in STAGES.iter().filter(|stage| !done.contains(stage.name)) {
            let Some(index) = first_step(fixture, stage.name, device).unwrap() else { continue };
            let Some(case) = case(device, fixture, index).unwrap() else { continue };
            assert!(!case.about.fails, "{}: {:?}", stage.name, case.about);
            let found = case.replay(device, 2).unwrap();
            assert!(found.passes() && found.words > 0, "{}: {found:?}", stage.name);
            // The device does the same in one submission as one dispatch at a time.
            for (part, left) in case.buffers.iter().zip(case.run(device).unwrap()) {
                assert_eq!(part.device, left, "{}: {}", stage.name, part.name);
            }
            // The minimized case does the same.
            let least = minimize(&case, device).unwrap();
            assert!(least.bytes() <= case.bytes() && least.replay(device, 1).unwrap().passes(), "{}", stage.name);
            let touched = least.bytes() < case.bytes();
            let asked = case.dispatches.iter().all(|dispatch| dispatch.kernel.contains("scan"));
            assert!(touched || asked || case.bytes() < 4000, "{}: {} bytes", stage.name, case.bytes());
            check(&case);
        }
    });
    done.extend(fixture.steps.iter().map(|step| step.stage.name));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_case_repeats_what_a_step_does() {
    let mut done = BTreeSet::new();
    for name in
        ["sphere with holes", "strip of 33 triangles (65 nodes), links", "lights of two colours, error estimate"]
    {
        let fixture = fixture(name).unwrap();
        all(&fixture, &mut done, |case| {
            // From its files, too.
            let here = tempfile::tempdir().unwrap();
            case.write(&here.path().join("case"), "-o").unwrap();
            let read = Case::read(&here.path().join("case")).unwrap();
            assert!(read.about == case.about && read.dispatches == case.dispatches, "{:?}", case.about);
            for (read, part) in read.buffers.iter().zip(&case.buffers) {
                let words = |part: &Part| (part.words.clone(), part.first, part.before.clone());
                assert!(words(read) == words(part), "{}: {}", case.about.stage, part.name);
                assert!(read.expected == part.expected && read.allowed == part.allowed, "{}", part.name);
                assert!(read.device == part.device, "{}: {}", case.about.stage, part.name);
            }
        });
    }
    assert!(done.len() > 15, "{done:?}");
}

#[test]
fn indirect_dispatches_become_direct() {
    on_devices(|device| {
        let fixture = fixture("sphere with holes").unwrap();
        let index = first_step(&fixture, "gather", device).unwrap().unwrap();
        let case = case(device, &fixture, index).unwrap().unwrap();
        let edge = case.dispatches.iter().find(|dispatch| dispatch.kernel.ends_with("/edge")).unwrap();
        assert!(edge.groups[0] > 0 && edge.groups.iter().all(|count| *count < 10_000), "{:?}", edge.groups);
    });
}
