//! Every stage on every fixture and every Vulkan device against the CPU, and proof that the harness detects errors.
//!
//! Fails without a device, unless `MILKGLASS_NO_DEVICE=1` waives it, which is printed.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, OnceLock};

use super::mutants;
use crate::devices::{on_devices, on_devices_each};
use milkglass::internals::gpu::{sources, spirv};
use milkglass::internals::layout::{BUFFER_IDS, BufferId};
use milkglass::internals::pipeline::frame::{STAGES, owner};
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options};
use milkglass::internals::session::run::{CapacityHints, Session};
use milkglass::internals::state::{Width, dispatches};
use milkglass::measure::conform::{Plant, Row, conform, conform_stages};
use milkglass::measure::fixtures::{Fixture, covered, fixture, fixtures};
use milkglass::measure::leaning::blame;
use milkglass::scene::Scene;
use spirq::spirv::Op;

/// A kernel that does nothing: the built-in SPIR-V with a return at the start of its entry point.
fn idle(kernel: &str) -> Vec<u32> {
    const HEADER: usize = 5;
    const BOUND: usize = 3;
    let mut words: Vec<u32> = bytemuck::pod_collect_to_vec(spirv(kernel).unwrap());
    let (mut entry, mut in_entry, mut labelled, mut at) = (0, false, false, HEADER);
    loop {
        let (length, op) = ((words[at] >> 16) as usize, Op::from_u32(words[at] & 0xffff));
        match op {
            Some(Op::EntryPoint) => entry = words[at + 2],
            Some(Op::Function) => in_entry = words[at + 2] == entry,
            Some(Op::Label) if in_entry => labelled = true,
            Some(Op::Variable) => {}
            // The rest becomes a block that no branch reaches.
            _ if labelled => break,
            _ => {}
        }
        at += length;
    }
    let instruction = |words: u32, op: Op| words << 16 | op as u32;
    words.splice(at..at, [instruction(1, Op::Return), instruction(2, Op::Label), words[BOUND]]);
    words[BOUND] += 1;
    words
}

/// All fixtures, built once.
pub fn all() -> &'static [Fixture] {
    static LIST: OnceLock<Vec<Fixture>> = OnceLock::new();
    LIST.get_or_init(|| fixtures("").unwrap())
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn every_stage_conforms_on_every_fixture() {
    let list = all();
    for stage in STAGES {
        assert!(covered(list, stage.name), "no fixture runs stage {}", stage.name);
    }
    // Large fixtures are last in the list; run them first.
    let largest_first: Vec<&Fixture> = list.iter().rev().collect();
    let (faults, all_rows) = (Mutex::new(Vec::new()), Mutex::new(BTreeMap::<String, Vec<Row>>::new()));
    on_devices_each(&largest_first, |device, fixture| {
        let rows = conform(device, fixture, &[]).unwrap();
        assert!(!rows.is_empty(), "{} compared nothing", fixture.name);
        all_rows.lock().unwrap().entry(device.name().to_string()).or_default().extend(rows.iter().cloned());
        for row in rows {
            assert!(row.distances.words > 0, "{}: {} compared no word", fixture.name, row.stage);
            let named = row.faults.into_iter().map(|fault| format!("{}, {}: {fault}", device.name(), fixture.name));
            faults.lock().unwrap().extend(named);
        }
    });
    let mut faults = faults.into_inner().unwrap();
    // Over all fixtures, no stage leans to one side.
    for (device, mut rows) in all_rows.into_inner().unwrap() {
        rows.iter_mut().for_each(|row| row.faults.clear());
        blame(&mut rows);
        faults.extend(rows.iter().flat_map(|row| &row.faults).map(|fault| format!("{device}: {fault}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_overflowing_fixtures_overflow() {
    let after = |name: &str| {
        let fixture = fixture(name).unwrap();
        let mut state = fixture.state.clone();
        fixture.steps.iter().for_each(|step| step.reference(&mut state));
        (state.data.counters[0], state.data.object_params[0])
    };
    let (counters, params) = after("links that overflow");
    assert!(counters.overflow == 1 && counters.required_links > params.link_capacity, "{counters:?}");
    let (counters, params) = after("hand-downs that overflow");
    assert!(counters.overflow == 1 && counters.required_hands > params.hand_capacity, "{counters:?}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_planted_error_is_reported_by_name() {
    let list = all();
    on_devices(|device| {
        // For each written buffer, a small fixture in which it is not empty.
        let mut plants: BTreeMap<usize, Vec<Plant>> = BTreeMap::new();
        for stage in STAGES {
            for slot in stage.results() {
                let fixture = list.iter().position(|fixture| {
                    fixture.steps.iter().any(|step| step.stage.name == stage.name)
                        && !fixture.state.data.bytes(slot).is_empty()
                        && fixture.state.data.triangles.len() < 2000
                });
                let fixture = fixture.unwrap_or_else(|| panic!("no small fixture writes {slot:?}"));
                plants.entry(fixture).or_default().push(Plant { stage: stage.name, slot });
            }
        }
        let mut noticed = BTreeSet::new();
        for (fixture, plants) in plants {
            let fixture = &list[fixture];
            let rows = conform(device, fixture, &plants).unwrap();
            for plant in plants {
                let fault = format!("{}[0]", plant.slot.spec().name);
                let seen = |row: &Row| row.stage == plant.stage && row.faults.iter().any(|text| text.contains(&fault));
                if rows.iter().any(seen) {
                    noticed.insert(format!("{} after {}", plant.slot.spec().name, plant.stage));
                }
            }
        }
        mutants::check("flipped", &noticed);

        // And in a buffer that the stage does not write.
        let fixture = list.iter().find(|fixture| fixture.name == "sphere with holes").unwrap();
        let plant = Plant { stage: "push", slot: BufferId::positions };
        let rows = conform(device, fixture, &[plant]).unwrap();
        let seen = |row: &Row| {
            row.faults
                .iter()
                .any(|fault| fault.contains("changed though not written") && fault.contains("positions[0]"))
        };
        assert!(rows.iter().any(seen));
    });
}

#[test]
fn kernels_write_what_their_stage_declares() {
    use milkglass::internals::gpu::{accesses, kernel_names};
    for stage in STAGES {
        let own = kernel_names().filter(|name| stage.owns(name));
        let written = own.flat_map(|name| accesses(name).unwrap()).filter(|access| access.writes);
        let written: BTreeSet<BufferId> = written.map(|access| BUFFER_IDS[access.binding as usize]).collect();
        let declared: BTreeSet<BufferId> = stage.writes.iter().map(|(slot, _, _)| *slot).collect();
        assert_eq!(written, declared, "stage {}", stage.name);
    }
}

fn scene(sets: &[&str]) -> Scene {
    Scene::load_with("sphere", &sets.iter().map(|s| s.to_string()).collect::<Vec<_>>()).unwrap()
}

fn bits(session: &mut Session, slot: BufferId) -> Vec<u8> {
    session.fetch(&[slot]).unwrap();
    session.state().data.bytes(slot).to_vec()
}

fn overflow_changes_no_bit(scene: &Scene) {
    on_devices(|device| {
        let tight = CapacityHints {
            chunk_faces: 700,
            links: 1,
            batch_blocks: 60,
            binding: 1 << 18,
            ..CapacityHints::default()
        };
        for (mode, like) in
            [(Mode::OnTheFly, Mode::OnTheFly), (Mode::Keep, Mode::OnTheFly), (Mode::Render, Mode::Render)]
        {
            let options = Options { mode: like, ..Options::default() };
            let mut plain = Session::new(scene, Some(device), options).unwrap();
            plain.frame(Change::EVERYTHING).unwrap();
            let expected = bits(&mut plain, BufferId::radiosity);
            let options = Options { mode, ..Options::default() };
            let mut cut = Session::with_capacity(scene, Some(device), options, tight).unwrap();
            cut.frame(Change::EVERYTHING).unwrap();
            assert!(cut.retries() > 0, "nothing overflowed");
            let schedule = &cut.state().objects[0].schedule;
            assert!(schedule.chunks.len().max(schedule.batches.len()) > 4);
            assert_eq!(bits(&mut cut, BufferId::radiosity), expected);
            // Again, with the buffers' present contents.
            cut.frame(Change::EVERYTHING).unwrap();
            assert_eq!(bits(&mut cut, BufferId::radiosity), expected);
        }
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn render_mode_follows_the_light_bit_for_bit() {
    let links = "transport.scheme=links";
    let first = scene(&["object.0.detail=4", "camera.size=[32, 32]", links]);
    let second = scene(&["object.0.detail=4", "camera.size=[32, 32]", links, "light.0.direction=[-1, 0.2, 0.1]"]);
    on_devices(|device| {
        for backend in [Some(device), None] {
            let options = Options { mode: Mode::Render, goal: Goal::Picture, ..Options::default() };
            let mut kept = Session::new(&first, backend, options).unwrap();
            kept.frame(Change::EVERYTHING).unwrap();
            let before = bits(&mut kept, BufferId::radiance);
            kept.set_lights(&second.lights).unwrap();
            let steps = kept.frame(Change::LIGHT).unwrap();
            assert!(
                !steps.iter().any(|step| ["refine", "form_factor", "refit", "reach"].contains(&step.name.as_str()))
            );
            let after = bits(&mut kept, BufferId::radiance);
            assert_ne!(before, after);
            let mut fresh = Session::new(&second, backend, Options::default()).unwrap();
            fresh.frame(Change::EVERYTHING).unwrap();
            assert_eq!(bits(&mut fresh, BufferId::radiance), after);
        }
    });
}

mod rare {
    use super::*;

    /// Every kernel changes memory in some fixture.
    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn a_kernel_that_does_nothing_is_reported() {
        let list = all();
        // For each kernel, the fixtures that run it, small ones first.
        let mut order: Vec<usize> = (0..list.len()).collect();
        order.sort_by_key(|&k| list[k].state.data.triangles.len());
        let mut kernels: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for k in order {
            for dispatch in dispatches(&list[k].state, &list[k].steps, Width { subgroup: 8, shares: false }).unwrap() {
                let known = kernels.entry(dispatch.kernel).or_default();
                if known.last() != Some(&k) {
                    known.push(k);
                }
            }
        }
        for name in sources().filter(|name| !name.ends_with(".glsl") && !name.starts_with("measure/")) {
            assert!(kernels.contains_key(name), "no fixture runs kernel {name}");
        }
        let noticed = Mutex::new(BTreeMap::<String, BTreeSet<String>>::new());
        on_devices_each(&kernels.into_iter().collect::<Vec<_>>(), |device, (kernel, fixtures)| {
            let device = device.replacing(kernel, idle(kernel)).unwrap();
            let stage = [owner(kernel).unwrap().name.to_string()];
            let seen = |&k: &usize| {
                let rows = conform_stages(&device, &list[k], &stage).unwrap();
                // Validation messages about such a kernel do not count.
                rows.iter().any(|row| row.faults.iter().any(|fault| fault.contains("beyond tolerance")))
            };
            let is_noticed = fixtures.iter().any(seen);
            let mut noticed = noticed.lock().unwrap();
            let own = noticed.entry(device.name().to_string()).or_default();
            if is_noticed {
                own.insert(kernel.clone());
            }
        });
        for kernels in noticed.into_inner().unwrap().values() {
            mutants::check("idle", kernels);
        }
    }

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn overflow_and_chunks_change_no_bit() {
        for scheme in ["blocks", "links"] {
            overflow_changes_no_bit(&scene(&[
                "object.0.detail=4",
                "camera.size=[32, 32]",
                &format!("transport.scheme={scheme}"),
            ]));
        }
    }
}
