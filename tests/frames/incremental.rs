//! Links kept while the shape changes: they equal those of a frame from scratch, and the work stays within its budget.

use crate::devices;
use crate::shell::{bad, folder, good};
use milkglass::internals::gpu::Device;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::{CapacityHints, Session};
use milkglass::internals::state::{Object, Scope};
use milkglass::measure::modes::{What, moved};
use milkglass::scene::Scene;

const INCREMENTAL: Options =
    Options { transport: ShadingMethod::Hierarchy, mode: Mode::Incremental, goal: Goal::Radiosity, estimate: false };

pub fn at(name: &str, sets: &[&str], frame: f64) -> Scene {
    let mut all = vec!["transport.scheme=links".to_string()];
    all.extend(sets.iter().map(|set| set.to_string()));
    Scene::load_at(name, &all, frame).unwrap()
}

pub fn open(scene: &Scene, device: Option<&Device>, mode: Mode, room: CapacityHints) -> Session {
    let mut session = Session::with_capacity(scene, device, Options { mode, ..INCREMENTAL }, room).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

pub fn step(session: &mut Session, scene: &Scene) -> Vec<String> {
    session.show(scene).unwrap();
    session.frame(Change::default()).unwrap().into_iter().map(|part| part.name).collect()
}

/// Radiosity of all faces, without the values between the objects' parts.
pub fn radiosity(session: &mut Session) -> Vec<[f32; 3]> {
    session.fetch(&[BufferId::radiosity]).unwrap();
    let state = session.state();
    let own = |object: &Object| &state.data.radiosity[object.first.faces..][..object.count.faces];
    state.objects.iter().flat_map(own).copied().collect()
}

/// Every link of every receiver, with the bits of its form factor.
pub fn links(session: &mut Session) -> Vec<Vec<(u32, [u32; 3])>> {
    session.fetch(&[BufferId::spans, BufferId::links, BufferId::factors]).unwrap();
    let (state, data) = (session.state(), &session.state().data);
    let mut all = vec![Vec::new(); data.spans.len()];
    for (object, part) in state.objects.iter().enumerate() {
        for (chunk, nodes) in part.schedule.chunks.iter().map(|chunk| chunk.nodes.clone()).enumerate() {
            let base = state.part(BufferId::links, Scope { object, chunk, group: 0 }).0;
            for &node in &data.order[part.first.nodes..][nodes.start as usize..nodes.end as usize] {
                let span = data.spans[part.first.nodes + node as usize];
                let own = base + span.link as usize..base + (span.link + span.links) as usize;
                assert!(data.links[own.clone()].iter().all(|link| link.receiver == node));
                let link = |k: usize| (data.links[k].emitter, data.factors[k].map(f32::to_bits));
                all[part.first.nodes + node as usize] = own.map(link).collect();
            }
        }
    }
    all
}

/// The number of links that touch what the last frame changed, and of all links.
fn touched(session: &mut Session) -> (u64, u64) {
    let all = links(session);
    session.fetch(&[BufferId::change_flags]).unwrap();
    let altered = &session.state().data.change_flags;
    let touches = |(receiver, own): (usize, &Vec<(u32, [u32; 3])>)| {
        own.iter().filter(|(emitter, _)| (altered[receiver] | altered[*emitter as usize]) & 1 != 0).count() as u64
    };
    (all.iter().enumerate().map(touches).sum(), all.iter().map(|own| own.len() as u64).sum())
}

/// Runs a hundred frames; one in `stride` is compared with a frame from scratch, bit for bit.
fn hundred(name: &str, sets: &[&str], device: Option<&Device>, room: CapacityHints, stride: usize) {
    let frame = |k: usize| at(name, sets, 10.0 + 0.3 * k as f64);
    let mut session = open(&frame(0), device, Mode::Incremental, room);
    let (mut revised, mut compared) = (0, 0);
    for k in 1..=100 {
        let ran = step(&mut session, &frame(k));
        revised += usize::from(ran.iter().any(|name| name == "update_links"));
        assert_eq!(session.waiting(), 0);
        if k % stride == 1 {
            let mut fresh = open(&frame(k), device, Mode::Keep, room);
            assert!(links(&mut session) == links(&mut fresh), "{name} {k}: other links or form factors");
            assert!(radiosity(&mut session) == radiosity(&mut fresh), "{name} {k}: another radiosity");
            compared += 1;
        }
    }
    println!("{name}: {revised} of 100 frames revised, {} runs more, {compared} compared", session.retries());
    assert!(revised > 80, "{name}: only {revised} of 100 frames revised links");
}

const TWIST: &[&str] = &[
    "object.0.detail=1",
    "transport.budget=4000000000",
    "object.0.deform=[{ type = 'twist', angle = { keyframes = [[9, 0], [40, 12]] } }]",
];
const NOISE: &[&str] = &["object.0.detail=1", "transport.budget=4000000000"];
const BUMP: &[&str] = &["object.0.detail=3", "transport.budget=4000000000"];

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn so_they_are_on_devices() {
    devices::on_devices(|device| hundred("noise", NOISE, Some(device), CapacityHints::default(), 33));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn so_they_are_where_many_chunks_have_rooms_that_grow() {
    let tight = CapacityHints { chunk_faces: 200, links: 40, ..CapacityHints::default() };
    devices::on_devices(|device| hundred("bump", &["object.0.detail=4"], Some(device), tight, 33));
}

#[test]
fn a_local_bump_computes_form_factors_of_what_it_touches() {
    let scene = at("sphere", &["object.0.detail=3"], 0.0);
    let check = |device: Option<&Device>| {
        let mut session = open(&moved(&scene, What::Bump, 0), device, Mode::Incremental, CapacityHints::default());
        let (before, retries) = (links(&mut session), session.retries());
        let ran = step(&mut session, &moved(&scene, What::Bump, 1));
        assert!(
            ran.iter().any(|name| name == "update_form_factors") && !ran.iter().any(|name| name == "form_factor"),
            "{ran:?}"
        );
        let (touched, all) = touched(&mut session);
        let altered = session.state().data.change_flags.clone();
        let faces = session.state().data.leaves.iter().filter(|leaf| altered[**leaf as usize] & 1 != 0).count();
        let share = faces as f64 / session.state().data.leaves.len() as f64;
        println!("{:.2} % of the triangles altered: {} of {all} form factors", 100.0 * share, session.renewed());
        assert!((0.003..0.02).contains(&share), "{share}");
        // New links touch a changed cluster, or replace a link that did.
        assert!(session.renewed() > 0 && session.renewed() <= touched + touched / 4, "{} {touched}", session.renewed());
        assert!(touched < all / 4, "{touched} of {all}");

        // Only receivers with a link that touches a changed cluster, or with a removed link, are dispatched.
        assert_eq!(session.retries(), retries);
        let after = links(&mut session);
        let has = |own: &[(u32, [u32; 3])], emitter| own.binary_search_by_key(&emitter, |link| link.0).is_ok();
        let busy = |receiver: &usize| {
            let moved = altered[*receiver] & 1 != 0;
            let touches = after[*receiver].iter().any(|(emitter, _)| moved || altered[*emitter as usize] != 0);
            touches || before[*receiver].iter().any(|(emitter, _)| !has(&after[*receiver], *emitter))
        };
        let receivers = (0..after.len()).filter(busy).count();
        let counters = session.state().data.counters[0];
        assert_eq!([counters.edited, counters.summed].map(|n| n as usize), [receivers; 2]);
        assert!(0 < receivers && receivers < after.len() / 2, "{receivers} of {}", after.len());
    };
    check(None);
    devices::on_devices(|device| check(Some(device)));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_shadow_that_moves_over_what_does_not_is_summed_again() {
    let light = "light.0={ type = 'directional', direction = [1, 0, 0.15], irradiance = 3 }";
    let frame = |height: f64| {
        let bump =
            format!("object.0.deform=[{{ type = 'bump', position = [-3, 0, 2], radius = 3, height = {height} }}]");
        at("slab", &["object.0.detail=12", light, &bump], 0.0)
    };
    let check = |device: Option<&Device>| {
        let mut session = open(&frame(1.5), device, Mode::Incremental, CapacityHints::default());
        let ran = step(&mut session, &frame(2.0));
        assert!(ran.iter().any(|name| name == "resum_links") && !ran.iter().any(|name| name == "sum_links"), "{ran:?}");
        session.fetch(&[BufferId::change_flags]).unwrap();
        assert!(session.state().data.change_flags.contains(&2), "no shadow moved over what did not");
        let mut fresh = open(&frame(2.0), device, Mode::Keep, CapacityHints::default());
        assert!(links(&mut session) == links(&mut fresh), "other links or form factors");
        assert!(radiosity(&mut session) == radiosity(&mut fresh), "another radiosity");
    };
    check(None);
    devices::on_devices(|device| check(Some(device)));
}

#[test]
fn an_overflow_of_links_made_anew_beside_updated_ones_has_all_made_anew() {
    // Another shape and material for one object, so its links are made anew; the other's are updated.
    let frame = |height: f64, sigma_a: &str| {
        let bump =
            format!("object.0.deform=[{{ type = 'bump', position = [0, 0, 10], radius = 4, height = {height} }}]");
        let material = format!("object.0.material.sigma_a={sigma_a}");
        let other = [
            "object.1.shape=slab",
            "object.1.material={ preset='ketchup' }",
            "object.1.detail=2",
            "object.1.position=[60, 0, 0]",
        ];
        at("sphere", &[&["object.0.size=20", "object.0.detail=1", &bump, &material][..], &other].concat(), 0.0)
    };
    let check = |device: Option<&Device>| {
        let mut session = open(&frame(1.0, "0.001"), device, Mode::Incremental, CapacityHints::default());
        let retries = session.retries();
        let ran = step(&mut session, &frame(1.1, "[0.02, 0.004, 0.04]"));
        let both = ["update_links", "refine"].iter().all(|name| ran.iter().any(|ran| ran == name));
        assert!(both && session.retries() > retries, "{} {retries} {ran:?}", session.retries());
        let mut fresh = open(&frame(1.1, "[0.02, 0.004, 0.04]"), device, Mode::Keep, CapacityHints::default());
        assert!(links(&mut session) == links(&mut fresh), "other links or form factors");
        assert!(radiosity(&mut session) == radiosity(&mut fresh), "another radiosity");
    };
    check(None);
    devices::on_devices(|device| check(Some(device)));
}

#[test]
fn a_static_frame_dispatches_nothing_and_a_new_light_no_link() {
    devices::on_devices(|device| {
        let scene = at("bump", &["object.0.detail=12"], 20.0);
        let mut session = open(&scene, Some(device), Mode::Incremental, CapacityHints::default());
        assert!(session.frame(Change::default()).unwrap().is_empty());
        let ran: Vec<_> = session.frame(Change::LIGHT).unwrap().into_iter().map(|part| part.name).collect();
        for idle in [
            "deform",
            "refit",
            "reach",
            "mark_moved",
            "refine",
            "update_links",
            "update_form_factors",
            "form_factor",
            "snapshot",
        ] {
            assert!(!ran.iter().any(|name| name == idle), "{idle} ran: {ran:?}");
        }
        assert!(ran.iter().any(|name| name == "sum_links"));
    });
}

#[test]
fn what_other_scenes_have_is_not_used() {
    let scene = at("bump", &["object.0.detail=12"], 20.0);
    let session = open(&scene, None, Mode::Render, CapacityHints::default());
    for slot in [
        BufferId::kept_clusters,
        BufferId::kept_positions,
        BufferId::stale,
        BufferId::added_links,
        BufferId::edits,
        BufferId::change_flags,
    ] {
        assert!(session.state().data.bytes(slot).is_empty(), "{slot:?}");
    }
    let why = |name: &str| session.plan().left_out.iter().find(|(left, _)| *left == name).map(|(_, why)| why.clone());
    for name in ["mark_moved", "update_links", "update_form_factors", "snapshot"] {
        assert!(why(name).unwrap().contains("--mode incremental"), "{name}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_fixtures_revise_and_the_tight_ones_overflow() {
    let fixtures = milkglass::measure::fixtures::fixtures("kept links").unwrap();
    let mut tight = 0;
    for fixture in
        fixtures.into_iter().filter(|fixture| fixture.steps.iter().any(|step| step.stage.name == "update_links"))
    {
        let mut state = fixture.state.clone();
        fixture.steps.iter().for_each(|step| step.reference(&mut state));
        let (counters, name) = (state.data.counters[0], &fixture.name);
        if name.contains("too") {
            assert!(counters.overflow == 1 && counters.computed == 0, "{name}: {counters:?}");
            tight += 1;
        } else {
            assert!(counters.overflow == 0 && counters.computed > 0, "{name}: {counters:?}");
            assert_eq!(counters.stale > 0, name.contains("budget"), "{name}: {counters:?}");
        }
    }
    assert_eq!(tight, 2);
}

#[test]
fn a_fixture_has_blocks_whose_near_lists_are_gone() {
    let fixture = milkglass::measure::fixtures::fixture("lights of two colours, near lists that are gone").unwrap();
    let mut state = fixture.state.clone();
    fixture.steps.iter().for_each(|step| step.reference(&mut state));
    let [before, after] = [&fixture.state, &state].map(|state| &state.data.near_channels);
    assert_eq!(before.len(), after.len());
    // Bits of area lists, and of edge lists.
    let gone = |bits: u32| before.iter().zip(after).filter(|(old, new)| (**old & !**new) & bits != 0).count();
    assert!(gone(7) > 0 && gone(7 << 3) > 0);
}

#[test]
fn plan_tells_the_mode_and_what_blocks_do() {
    let here = folder(&[]);
    let plan = |more: &str| good(&here, &format!("plan sphere --set object.0.detail=1 --device cpu {more}")).0;
    let text = plan("--mode incremental --set transport.scheme=links --set transport.budget=500");
    assert!(text.contains("mode incremental") && text.contains("at most 500 form factors a frame"), "{text}");
    let text = plan("--mode incremental");
    assert!(
        text.contains("mode render") && text.contains("incremental links") && text.contains("lists of blocks"),
        "{text}"
    );
    let lines = ["solve sphere --verify 10 --set transport.budget=0", "plan sphere --set transport.budget=-1"];
    for line in lines {
        bad(&here, line, 2, &["transport.budget", "expected", "1 to"]);
    }
    let two = "plan sphere --mode incremental --set transport.scheme=links --set transport.budget=1 \
               --set object.1.shape=cube --set object.1.material.preset=marble --set object.1.position=[40,0,0]";
    bad(&here, two, 2, &["transport.budget", "found 1", "each object"]);
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn links_after_a_hundred_frames_are_those_of_a_frame_from_scratch() {
        for (name, sets) in [("twist", TWIST), ("noise", NOISE), ("bump", BUMP)] {
            hundred(name, sets, None, CapacityHints::default(), 33);
        }
    }
}
