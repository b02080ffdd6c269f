//! Kernels whose groups share an item conform at widths that processors do not choose. That all have the same bits is
//! held by `variants`.

use crate::devices::on_devices;
use milkglass::internals::gpu::Choices;
use milkglass::measure::conform::conform_stages;
use milkglass::measure::fixtures::{Fixture, fixture};
use milkglass::scene::Scene;

/// Words in which a group notes what it finds: `glsl/transport/blocks/share.glsl`.
const POOL: u32 = 1536;

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
    // Some blocks list more than a group can note, and are walked by parts of the tree.
    assert!(longest(&long) > POOL, "{}", longest(&long));
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

#[test]
fn stages_conform_where_invocations_share_items() {
    // Triangles that are large against the mean free path: near ones by area points and by the edge form.
    let sets = [
        "object.0.detail=2",
        "camera.size=[8, 8]",
        "transport.receivers=faces",
        "object.0.size=30",
        "transport.tolerance=1e-3",
    ];
    let scene = Scene::load_with("sphere", &sets.map(str::to_string)).unwrap();
    let coarse = Fixture::of_scene("sphere of large triangles", &scene).unwrap();
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
