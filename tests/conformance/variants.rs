//! However the Vulkan API is used, every buffer has the bits that it has by default; where a variant changes the
//! arithmetic, every stage conforms.

use std::collections::BTreeSet;

use milkglass::internals::gpu::{AXES, Choices, Device, Kernels, Timed};
use milkglass::internals::layout::BUFFER_IDS;
use milkglass::internals::pipeline::frame::STAGES;
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::DeviceState;
use milkglass::measure::fixtures::{Fixture, made};
use milkglass::measure::vary::{Computed, Proof, Variant, asked, computed_steps, lack, proof};

use super::features;
use super::stages::all;
use crate::devices::on_devices;

/// Small fixtures that together run most stages: with lists, a solver, joints, kept links, photons and layers.
const SOME: &[&str] = &[
    "bump over kept links, displaced sources",
    "diffusion in two objects, the dipole in a third",
    "dim beside bright, lists kept",
    "layers, even, left rule",
    "three objects, two of them with joints",
    "walk through clear and dark media",
];

pub fn some() -> Vec<Fixture> {
    let found = made(|name| SOME.contains(&name)).unwrap();
    assert_eq!(found.len(), SOME.len());
    found
}

/// The stages that these fixtures run.
fn stages_of(fixtures: &[Fixture]) -> BTreeSet<&'static str> {
    fixtures.iter().flat_map(|one| one.steps.iter().map(|step| step.stage.name)).collect()
}

/// The device opened again and used as chosen, with new buffers filled with 0, so that no byte is undefined.
fn cleared(device: &Device, choices: &Choices) -> Device {
    device.opened_as(&Choices { fill: Some(0), ..choices.clone() }).unwrap()
}

/// Compares every variant that a device can run with the default. Each variant runs every `parts`-th of these fixtures,
/// and the next variant begins with the next fixture; with 1, each runs all.
fn compare(fixtures: &[&Fixture], parts: usize) {
    let variants: Vec<Variant> = AXES.iter().flat_map(|axis| asked(axis.name).unwrap().variants).collect();
    on_devices(|device| {
        let run = |choices: &Choices, chosen: &[usize]| -> (Device, Vec<Computed>) {
            let device = cleared(device, choices);
            let all = chosen.iter().map(|&k| computed_steps(&device, fixtures[k]).unwrap()).collect();
            (device, all)
        };
        let default = run(&Choices::default(), &(0..fixtures.len()).collect::<Vec<_>>()).1;
        let mut ran = 0;
        for (number, variant) in variants.iter().enumerate() {
            if lack(device.adapter(), &variant.choices).is_some() {
                continue;
            }
            ran += 1;
            let chosen: Vec<usize> = (0..fixtures.len()).filter(|k| k % parts == number % parts).collect();
            let (opened, own) = run(&variant.choices, &chosen);
            for (&k, own) in chosen.iter().zip(&own) {
                let fixture = &fixtures[k];
                let again = || {
                    Ok(Fixture {
                        name: fixture.name.clone(),
                        state: fixture.state.clone(),
                        steps: fixture.steps.clone(),
                    })
                };
                match proof(&variant.name, [&default[k], own], &opened, &again) {
                    Ok(Proof::Same { buffers, .. }) => assert!(buffers > 0, "{}", fixture.name),
                    Ok(Proof::Conforms { differ, .. }) => {
                        println!("{}: {}: other bits in {differ:?}", variant.name, fixture.name)
                    }
                    Err(error) => panic!("{}: {}: {}: {error}", device.name(), variant.name, fixture.name),
                }
            }
        }
        println!("{}: {ran} of {} variants; it lacks something for the others", device.name(), variants.len());
        assert!(ran >= 20, "{}: {ran} of {}", device.name(), variants.len());
    });
}

/// What is left of fixtures whose steps run in turn by two sets of kernels: in each buffer what a frame leaves.
fn in_turn(fixtures: &[Fixture]) {
    on_devices(|device| {
        let device = cleared(device, &Choices::default());
        for fixture in fixtures {
            let left = |alternates: bool| {
                let mut state = fixture.state.clone();
                let mut copy = DeviceState::new(&device, false).unwrap();
                copy.upload(&state, BUFFER_IDS).unwrap();
                for step in &fixture.steps {
                    if !alternates {
                        copy.run(&state, &[*step]).unwrap();
                        continue;
                    }
                    let mut others = Kernels::new(&device);
                    let rounds = [[false, true], [true, false]];
                    let times = copy.alternate(&state, *step, &mut others, &rounds).unwrap();
                    assert!(times.len() == 4 && times.iter().all(|time| time.name == step.stage.name), "{times:?}");
                    assert!(times.iter().all(|time| time.dispatches == times[0].dispatches), "{times:?}");
                }
                copy.download(&mut state, BUFFER_IDS).unwrap();
                state
            };
            let (once, four_times) = (left(false), left(true));
            for id in BUFFER_IDS {
                let same = once.data.bytes(*id) == four_times.data.bytes(*id);
                assert!(same, "{}: {}: {}", device.name(), fixture.name, id.spec().name);
            }
        }
    });
}

#[test]
fn steps_in_turn_find_the_same_state() {
    // Whose steps add to pictures.
    in_turn(&made(|name| name == SOME[3]).unwrap());
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn steps_of_all_kinds_in_turn_find_the_same_state() {
    in_turn(&some());
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_use_that_computes_something_else_is_refused() {
    let two = made(|name| SOME[3..5].contains(&name)).unwrap();
    on_devices(|device| {
        let device = cleared(device, &Choices::default());
        let [one, other] = [0, 1].map(|k: usize| computed_steps(&device, &two[k]).unwrap());
        let never = || unreachable!("no other arithmetic was chosen");
        let Err(error) = proof("this", [&one, &other], &device, &never) else { panic!("{}", device.name()) };
        assert!(
            error.to_string().starts_with("this computes something else, so that it was not timed: buffer "),
            "{error}"
        );
        assert!(proof("this", [&one, &one], &device, &never).is_ok());
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn every_use_of_the_api_computes_the_same() {
    let fixtures = some();
    let stages = stages_of(&fixtures);
    assert!(stages.len() >= 40, "{}: {stages:?}", stages.len());
    compare(&fixtures.iter().collect::<Vec<_>>(), 6);
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn every_use_of_the_api_computes_the_same_in_every_stage() {
        let mut stages = BTreeSet::new();
        let runs_another = |fixture: &&Fixture| {
            let before = stages.len();
            stages.extend(fixture.steps.iter().map(|step| step.stage.name));
            stages.len() > before
        };
        let first = some();
        let rest = all().iter().filter(|one| !SOME.contains(&one.name.as_str()));
        let chosen: Vec<&Fixture> = first.iter().chain(rest).filter(runs_another).collect();
        assert!(STAGES.iter().all(|stage| stages.contains(stage.name)), "{stages:?}");
        println!("{:?}", chosen.iter().map(|one| &one.name).collect::<Vec<_>>());
        compare(&chosen, 1);
    }
}

#[test]
fn lists_of_a_block_are_summed_side_by_side() {
    let scene = features::ball(&["transport.tolerance=1e-3"]);
    on_devices(|device| {
        let gather = |estimate: bool| {
            let options = Options { goal: Goal::Radiosity, estimate, ..Options::default() };
            let mut session = Session::new(&scene, Some(device), options).unwrap();
            let times = session.frame(Change::EVERYTHING).unwrap();
            let step = times.iter().find(|step| step.name == "gather").unwrap();
            [step.dispatches, step.barriers]
        };
        // One barrier, after the lists are written; no buffer that is empty without estimates makes another.
        assert_eq!(gather(false), [4, 1]);
        // The estimates of all lists are added up in one buffer.
        let [dispatches, barriers] = gather(true);
        assert!(dispatches == 5 && barriers > 2, "{dispatches} dispatches, {barriers} barriers");
    });
}

#[test]
fn a_kernel_that_is_timed_has_the_device_to_itself() {
    let scene = features::ball(&[]);
    on_devices(|device| {
        for timed in [Timed::Kernels, Timed::Dispatches] {
            let device = device.opened_as(&Choices { timed, ..device.choices().clone() }).unwrap();
            let mut session = Session::new(&scene, Some(&device), Options::default()).unwrap();
            let times = session.frame(Change::EVERYTHING).unwrap();
            let gather = times.iter().filter(|step| step.name.contains("blocks/gather/"));
            let parts: Vec<_> = gather.map(|step| (step.dispatches, step.barriers)).collect();
            assert!(parts.len() == 4 && parts.iter().all(|part| *part == (1, 1)), "{parts:?}");
        }
    });
}
