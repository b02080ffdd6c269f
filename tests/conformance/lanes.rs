//! Kernels whose groups share an item conform at widths that processors do not choose, and have the same bits at all.

use crate::devices::on_devices;
use milkglass::internals::gpu::Choices;
use milkglass::measure::conform::conform_stages;
use milkglass::measure::fixtures::{Fixture, fixture};
use milkglass::measure::interpret::stage::{Interpreter, Settings};
use milkglass::measure::vary::{Proof, computed_steps, proof};
use milkglass::scene::Scene;

/// Words of which a group makes a part: `glsl/transport/blocks/link/noted.glsl`.
const PART: u32 = 512;

/// The longest list of a block that the reference makes.
fn longest(fixture: &Fixture) -> u32 {
    let mut state = fixture.state.clone();
    fixture.steps.iter().for_each(|step| step.reference(&mut state));
    state.data.runs.iter().map(|run| run.expanded + run.direct + run.area + run.edge).max().unwrap_or(0)
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn groups_that_share_walks_conform() {
    let sets = ["object.0.detail=5", "transport.tolerance=1e-6", "camera.size=[8, 8]", "transport.receivers=faces"];
    let scene = Scene::load_with("sphere", &sets.map(str::to_string)).unwrap();
    let long = Fixture::of_scene("sphere with long lists", &scene).unwrap();
    // Some blocks list more than three parts take.
    assert!(longest(&long) > 3 * PART, "{}", longest(&long));
    let stages = ["coarse_solve", "link", "gather"].map(str::to_string);
    // Long lists take most of the time, and fill a group of any size.
    for (fixture, sizes) in [(fixture("sphere with holes").unwrap(), &[32, 128][..]), (long, &[128])] {
        on_devices(|device| {
            for &lanes in sizes {
                let wide = device.opened_as(&Choices { lanes: Some(lanes), ..device.choices().clone() }).unwrap();
                let rows = conform_stages(&wide, &fixture, &stages).unwrap();
                assert!(rows.len() >= stages.len(), "{} rows", rows.len());
                let faults: Vec<&String> = rows.iter().flat_map(|row| &row.faults).collect();
                assert!(faults.is_empty(), "{}, {lanes} lanes: {faults:?}", fixture.name);
            }
        });
    }
}

/// A ball of triangles that are large against the mean free path: near ones by area points and by the edge form.
fn coarse() -> Fixture {
    let sets = [
        "object.0.detail=2",
        "camera.size=[8, 8]",
        "transport.receivers=faces",
        "object.0.size=30",
        "transport.tolerance=1e-3",
    ];
    let scene = Scene::load_with("sphere", &sets.map(str::to_string)).unwrap();
    Fixture::of_scene("sphere of large triangles", &scene).unwrap()
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn bits_are_the_same_at_every_width() {
    for fixture in [coarse(), fixture("diffusion in a ball").unwrap()] {
        on_devices(|device| {
            let with = |lanes: u32| {
                let choices = Choices { lanes: Some(lanes), fill: Some(0), ..device.choices().clone() };
                let wide = device.opened_as(&choices).unwrap();
                let found = computed_steps(&wide, &fixture).unwrap();
                (wide, found)
            };
            let again = || {
                let Fixture { name, state, steps } = &fixture;
                Ok(Fixture { name: name.clone(), state: state.clone(), steps: steps.clone() })
            };
            let alone = with(1).1;
            for lanes in [32, 64, 128] {
                let (wide, shared) = with(lanes);
                match proof("lanes", [&alone, &shared], &wide, &again).unwrap() {
                    Proof::Same { buffers, .. } => assert!(buffers > 10, "{buffers}"),
                    Proof::Conforms { differ, .. } => {
                        panic!("{}: {}, {lanes} lanes: other bits in {differ:?}", device.name(), fixture.name)
                    }
                }
            }
        });
    }
}

/// What no driver here does: it takes each product that it may into a sum, which one of a GPU may do at one width and
/// not at another.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn bits_are_the_same_at_every_width_where_sums_take_products() {
    for fixture in [coarse(), fixture("diffusion in a ball").unwrap()] {
        let at = |contracts: bool| {
            let with = |lanes: u32| {
                Interpreter::with(Settings { lanes, wide: lanes, contracts, ..Settings::default() }, Vec::new())
            };
            [1, 32, 128].map(with)
        };
        let (both, mut state, mut changed) = ([false, true].map(at), fixture.state.clone(), Vec::new());
        for step in &fixture.steps {
            let bits = |interpreter: &Interpreter| {
                let mut own = state.clone();
                interpreter.run(&state, *step, false).unwrap().write(&mut own);
                step.stage.results().map(|id| own.data.bytes(id).to_vec()).collect::<Vec<_>>()
            };
            let [apart, contracted] = both.each_ref().map(|widths| {
                let [alone, some, all] = widths.each_ref().map(bits);
                assert!(alone == some && alone == all, "{}: {step}", fixture.name);
                alone
            });
            changed.extend((apart != contracted).then_some(step.stage.name));
            step.reference(&mut state);
        }
        assert!(changed.contains(&"gather") || changed.contains(&"boundary_integrals"), "{changed:?}");
    }
}

#[test]
fn stages_conform_where_invocations_share_items() {
    let coarse = coarse();
    let mut state = coarse.state.clone();
    coarse.steps.iter().for_each(|step| step.reference(&mut state));
    assert!(state.data.runs.iter().any(|run| run.edge > 0) && state.data.runs.iter().any(|run| run.area > 0));
    for (fixture, stages) in [
        (coarse, vec!["refit", "shadow", "pull", "acceptance_radii", "link", "gather"]),
        (fixture("diffusion in a ball").unwrap(), vec!["near_layers", "boundary_integrals", "krylov_step"]),
        (fixture("three objects, links kept").unwrap(), vec!["placement", "mean_irradiance"]),
        (fixture("bump over kept links").unwrap(), vec!["mark_moved"]),
        (fixture("layers, even, on a slab").unwrap(), vec!["plane_fit"]),
        (fixture("cdrf, closed form").unwrap(), vec!["curvature_sums"]),
    ] {
        let stages: Vec<String> = stages.into_iter().map(String::from).collect();
        on_devices(|device| {
            let wide = device.opened_as(&Choices { lanes: Some(64), ..device.choices().clone() }).unwrap();
            let rows = conform_stages(&wide, &fixture, &stages).unwrap();
            assert!(
                stages.iter().all(|stage| rows.iter().any(|row| row.stage == stage)),
                "{}: a stage is missing",
                fixture.name
            );
            let faults: Vec<&String> = rows.iter().flat_map(|row| &row.faults).collect();
            assert!(faults.is_empty(), "{}: {faults:?}", fixture.name);
        });
    }
}
