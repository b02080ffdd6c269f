//! Measurement: counts are correct, profiles are consistent, and a frame creates exactly what its plan lists.

use std::collections::BTreeSet;

use super::features::{ball, features};
use crate::devices::on_devices;
use milkglass::internals::gpu::count::Traffic;
use milkglass::internals::gpu::{Choices, Device, KernelKey, SingleKernel, Timed};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::frame::{STAGES, stage};
use milkglass::internals::pipeline::plan::{Change, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Width;
use milkglass::measure::interpret::stage::{self, Interpreter};
use milkglass::measure::profile::{
    Model, Open, Predicted, Settings, Work, against, interpreted, predict, predict_interpreted, profile, work,
};
use milkglass::scene::Scene;

static COUNT: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tests-kernels-count.spv"));
static WAITS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tests-kernels-waits.spv"));
static CHAIN: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tests-kernels-chain.spv"));

#[test]
fn kernels_count_what_they_do() {
    counts_by_hand(COUNT);
}

/// Buffers are uniform ones before SPIR-V 1.3, and entry points list inputs only before 1.4.
#[cfg(feature = "shaderc")]
#[test]
fn kernels_of_older_versions_count_the_same() {
    use milkglass::internals::gpu::source;
    use shaderc::{CompileOptions, Compiler, EnvVersion, ResolvedInclude, ShaderKind, TargetEnv};
    for (target, version) in [(EnvVersion::Vulkan1_0, 0x10000), (EnvVersion::Vulkan1_1, 0x10300)] {
        let mut options = CompileOptions::new().unwrap();
        options.set_target_env(TargetEnv::Vulkan, target as u32);
        options.set_include_callback(|name, _, _, _| {
            let content = source(name).ok_or("unknown")?.into_owned();
            Ok(ResolvedInclude { resolved_name: name.into(), content })
        });
        let text = include_str!("../kernels/count.comp");
        let made = Compiler::new().unwrap();
        let made = made.compile_into_spirv(text, ShaderKind::Compute, "count.comp", "main", Some(&options)).unwrap();
        assert_eq!(made.as_binary()[1], version);
        counts_by_hand(made.as_binary_u8());
    }
}

fn counts_by_hand(spirv: &[u8]) {
    on_devices(|device| {
        for (elements, rounds) in [(1000u64, 10u64), (64, 1), (1, 0)] {
            let size: Vec<u8> = [elements, rounds].iter().flat_map(|&n| (n as u32).to_ne_bytes()).collect();
            let mut buffers = [size, 1f32.to_ne_bytes().repeat(elements as usize)];
            let alone = SingleKernel { name: "count", spirv, constants: &[] };
            let tally = alone.tally(device, &mut buffers, elements).unwrap().unwrap();
            let all = elements.next_multiple_of(64);
            assert_eq!(tally.invocations, all, "{}", device.name());
            assert_eq!((tally.exps, tally.roots), (elements * rounds.div_ceil(4), elements), "{elements} x {rounds}");
            // One multiplication and one addition per round; five operations in the dot product, and the sum after it.
            assert_eq!(tally.flops, elements * (2 * rounds + 6), "{elements} x {rounds}");
            assert_eq!(tally.moved[&0], Traffic { loaded: 8 * all, stored: 0 });
            assert_eq!(tally.moved[&1], Traffic { loaded: 8 * elements, stored: 4 * elements });
        }
    });
}

#[test]
fn the_longest_chain_of_loads_is_counted() {
    on_devices(|device| {
        for (elements, rounds) in [(1000u64, 10u64), (64, 0), (1, 3)] {
            let size: Vec<u8> = [elements, rounds].iter().flat_map(|&n| (n as u32).to_ne_bytes()).collect();
            let next: Vec<u8> = (0..elements as u32).flat_map(|k| ((k + 1) % elements as u32).to_ne_bytes()).collect();
            let mut buffers = [size, next.clone(), next];
            let alone = SingleKernel { name: "chain", spirv: CHAIN, constants: &[] };
            let tally = alone.tally(device, &mut buffers, elements).unwrap().unwrap();
            let place = |k: u64| ((k + rounds + k) % elements + 2) % elements + (k + 1) % elements;
            let found: Vec<u64> =
                buffers[2].chunks(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]).into()).collect();
            assert_eq!(found, (0..elements).map(place).collect::<Vec<_>>());
            // The size is loaded first, by all; then come the list and the two loads after it.
            let (all, last) = (elements.next_multiple_of(64), elements - 1);
            let longest = tally.longest;
            assert_eq!(
                (longest.loads, longest.shared),
                (1 + rounds + last + 2, 0),
                "{}: {elements} x {rounds}",
                device.name()
            );
            assert_eq!(
                tally.chains.loads,
                all + elements * (rounds + 2) + last * elements / 2,
                "{elements} x {rounds}"
            );
            // Invocations differ by their steps only: by how much they lag behind the last one, its step follows.
            if elements == all {
                let (lag, steps) = (elements * longest.steps - tally.chains.steps, last * elements / 2);
                assert!(lag % steps == 0 && (3..30).contains(&(lag / steps)), "{lag} over {steps} steps");
            }
        }
    });
}

#[test]
fn what_a_subgroup_issues_counts_once_however_many_of_its_invocations_run_it() {
    on_devices(|device| {
        let counted = |elements: u64, rounds: u64| {
            let size: Vec<u8> = [elements, rounds].iter().flat_map(|&n| (n as u32).to_ne_bytes()).collect();
            let next: Vec<u8> = (0..elements as u32).flat_map(|k| ((k + 1) % elements as u32).to_ne_bytes()).collect();
            let alone = SingleKernel { name: "chain", spirv: CHAIN, constants: &[] };
            let tally = alone.tally(device, &mut [size, next.clone(), next], elements).unwrap().unwrap();
            (tally.instructions, tally.issued, tally.invocations / tally.subgroups)
        };
        // Further rounds of a loop that all invocations of 64 run, and that one of 64 does.
        for (elements, alone) in [(64, false), (1, true)] {
            let ((few, few_issued, width), (many, many_issued, _)) = (counted(elements, 1), counted(elements, 11));
            let active = if alone { 1 } else { width };
            assert!(width > 1, "{}", device.name());
            assert!(many_issued > few_issued, "{elements}: {few_issued} and {many_issued}");
            assert_eq!(many - few, active * (many_issued - few_issued), "{}: {elements}", device.name());
        }
    });
}

#[test]
fn waits_in_a_group_come_one_after_the_other() {
    on_devices(|device| {
        let mut buffers = [[100u32, 0].iter().flat_map(|n| n.to_ne_bytes()).collect(), vec![0; 256]];
        let alone = SingleKernel { name: "waits", spirv: WAITS, constants: &[] };
        let tally = alone.tally(device, &mut buffers, 64).unwrap().unwrap();
        assert_eq!(buffers[1][..4], 103u32.to_ne_bytes());
        assert_eq!((tally.longest.loads, tally.longest.shared), (1, 5), "{}", device.name());
        assert_eq!((tally.chains.loads, tally.chains.shared), (64, 64 * 5), "{}", device.name());
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_profile_hangs_together() {
    on_devices(|device| {
        let scene = ball(&[]);
        let found = profile(&scene, Some(device), &Settings { frames: 3, ..Settings::default() }).unwrap();
        let rates = found.rates.expect("every driver of these tests has timestamps");
        assert!(rates.copy > 1e6 && rates.fma > 1e6 && rates.exp > 1e6, "{rates:?}");
        // Notes on other programs' load and on drift do not depend on the profile.
        let outside = |note: &&String| note.starts_with("other programs kept") || note.starts_with("drift: ");
        let own: Vec<_> = found.notes.iter().filter(|note| !outside(note)).collect();
        assert!(own.is_empty() && found.peak > 100_000, "{own:?}");
        let row = |name: &str| found.rows.iter().find(|row| row.stage == name).unwrap();
        // One value of 12 bytes per face, and invocations in groups of 64.
        for name in ["irradiance", "push"] {
            let work = row(name).work.unwrap();
            assert_eq!((work.invocations, work.stored, work.written), (320, 320 * 12, 320 * 12), "{name}");
        }
        for row in &found.rows {
            let (work, time) = (row.work.unwrap(), row.device.unwrap());
            assert!(row.dispatches >= row.steps && work.invocations > 0 && work.written > 0, "{row:?}");
            assert!(work.read <= work.loaded && work.written <= work.stored, "{row:?}");
            assert!(time.low <= time.median && time.median <= time.high && time.low > 0.0 && row.wall.median > 0.0);
            assert!(row.share_of_copy(&rates).unwrap() > 0.0);
        }
        assert!(row("gather").work.unwrap().exps > 0 && row("link").work.unwrap().exps == 0);
        assert_eq!(found.trace.len(), 3);
        // Slow frames reduce the number of frames.
        let few = profile(&scene, Some(device), &Settings { frames: 9, enough: 0.0, ..Settings::default() }).unwrap();
        assert_eq!((few.frames, few.trace.len()), (3, 3));
    });
}

/// What the interpreter counts is what a device of its width counts, but for what devices choose: which invocations a
/// subgroup runs together, how wide a group is that goes through all elements alone, and on llvmpipe that a subgroup
/// needs no barrier and that no group climbs. Which triangles a shaft meets depends on how its bounds round.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_interpreter_counts_what_devices_do() {
    let scene = ball(&["object.0.detail=1", "camera.size=[16, 12]"]);
    let settings = Settings::default();
    on_devices(|device| {
        for lanes in [1, 64] {
            let choices = Choices { lanes: Some(lanes), timed: Timed::Kernels, ..device.choices().clone() };
            let device = device.opened_as(&choices).unwrap();
            let counts = work(&scene, &device, &settings).unwrap();
            let subgroup = Width::of(&device).subgroup as u32;
            let interpreter =
                Interpreter::with(stage::Settings { lanes, subgroup, ..stage::Settings::counting() }, Vec::new());
            let rows = interpreted(&scene, &interpreter, &settings, Timed::Kernels).unwrap();
            assert_eq!(rows.iter().map(|row| &row.stage).collect::<BTreeSet<_>>(), counts.keys().collect());
            for row in &rows {
                let [own, other] = [row.work, counts[&row.stage]].map(|work| Work { issued: 0, ..work });
                let place = format!("{}, {lanes} lanes: {}", device.name(), row.stage);
                match row.stage.as_str() {
                    name if lanes > 1 && name.ends_with("/cluster") => {}
                    "view/visibility" | "lighting/shadow" => {
                        assert_eq!((own.loaded, own.stored), (other.loaded, other.stored), "{place}");
                        assert!(own.flops.abs_diff(other.flops) < own.flops / 50, "{place}: {own:?}, {other:?}");
                    }
                    _ => assert_eq!(own, other, "{place}"),
                }
            }
        }
    });
}

/// A prediction is the same, but for clusters, whose dispatches llvmpipe makes level by level and whose chains depend
/// on who climbs, and but for the walks above. Diffusion is solved in several submissions.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_interpreter_predicts_what_devices_do() {
    let scene = ball(&["object.0.detail=0", "camera.size=[8, 6]", "transport.tolerance=0.1"]);
    let model = Model::read("h100").unwrap();
    on_devices(|device| {
        let choices = Choices { lanes: Some(stage::LANES), timed: Timed::Kernels, ..device.choices().clone() };
        let device = device.opened_as(&choices).unwrap();
        let wide = device.limits().group_invocations.min(1024);
        let subgroup = Width::of(&device).subgroup as u32;
        let widths = stage::Settings { wide, subgroup, ..stage::Settings::counting() };
        let interpreter = Interpreter::with(widths, Vec::new());
        for transport in [ShadingMethod::Hierarchy, ShadingMethod::Diffusion] {
            let options = Options { transport, ..Options::default() };
            let settings = Settings { options, ..Settings::default() };
            let own = predict_interpreted(&scene, &interpreter, (&settings, Timed::Kernels), &model).unwrap();
            let other = predict(&scene, &device, &settings, &model).unwrap();
            assert_eq!(own.submissions, other.submissions, "{transport:?} on {}", device.name());
            assert_eq!(own.rows.len(), other.rows.len(), "{:?}, {:?}", own.rows, other.rows);
            let walks = ["view/visibility", "lighting/shadow"];
            let mut same = 0;
            for (own, other) in own.rows.iter().zip(&other.rows) {
                assert_eq!(own.stage, other.stage);
                match own.stage.as_str() {
                    name if name.ends_with("/cluster") => {}
                    name if walks.contains(&name) => {
                        assert_eq!(own.launches_us, other.launches_us, "{name}");
                        assert!((own.us() / other.us() - 1.0).abs() < 0.1, "{own:?}, {other:?}");
                    }
                    _ => {
                        // What runs beside one of those walks shares its time.
                        let counted = |row: &Predicted| Predicted {
                            issue_us: 0.0,
                            residence_us: 0.0,
                            chain_us: 0.0,
                            ..row.clone()
                        };
                        assert_eq!(counted(own), counted(other), "{transport:?} on {}", device.name());
                        assert!((own.us() / other.us() - 1.0).abs() < 1e-3, "{own:?}, {other:?}");
                        same += 1;
                    }
                }
            }
            assert!(same > 15, "{:?}", own.rows);
        }
    });
}

#[test]
fn on_the_cpu_a_profile_has_times_only() {
    let found = profile(&ball(&[]), None, &Settings { frames: 2, ..Settings::default() }).unwrap();
    assert!(found.rates.is_none() && found.on_device.is_none() && found.wall.median > 0.0);
    assert!(found.rows.iter().all(|row| row.work.is_none() && row.device.is_none() && row.wall.median >= 0.0));
    assert!(found.rows.iter().any(|row| row.stage == "gather"));
    // Further notes may tell of drift and of other programs' load.
    assert!(found.notes[0].starts_with("on the CPU"), "{:?}", found.notes);
}

#[test]
fn a_device_against_itself_takes_every_stage() {
    on_devices(|device| {
        let open = || Ok(Some(device.clone()));
        let (scene, settings) = (ball(&[]), Settings { frames: 3, ..Settings::default() });
        let mut forecast = None;
        let devices: [(&str, Open<'_>); 2] = [("first", &open), ("second", &open)];
        let edited = ["gather".to_string()];
        let found = against(&scene, &devices, &settings, &edited, &mut |told| forecast = Some(*told)).unwrap();
        let forecast = forecast.unwrap();
        assert_eq!((forecast.each, forecast.fewest[0]), (1, 6));
        assert!(forecast.starts >= 9 && found.samples.orders.len() == forecast.starts, "{forecast:?}");
        let rows = found.samples.ratios().remove(0);
        let names: Vec<_> = rows.iter().map(|row| row.what.as_str()).collect();
        assert!(names.contains(&"gather") && names.ends_with(&["stages", "frame"]), "{names:?}");
        assert!(rows.iter().all(|row| row.ratio.value > 0.0 && row.missing_rounds == 0), "{rows:?}");
    });
}

/// Kernels, buffers, and dispatches per stage.
type Made = (BTreeSet<String>, BTreeSet<BufferId>, Vec<(&'static str, usize)>);

/// What frames created and dispatched on a device; checks that this is what the plan lists.
fn made(device: &Device, scene: &Scene, options: Options) -> Made {
    let mut session = Session::new(scene, Some(device), options).unwrap();
    let mut needs = Vec::new();
    // Incremental mode builds links in the first frame and updates them in the second.
    for revises in 0..1 + u32::from(options.mode == Mode::Incremental) {
        session.frame(Change::EVERYTHING.and(Change::TONE)).unwrap();
        let scratch = if revises == 0 { Change::RELINK } else { Change::default() };
        needs.extend(session.needs(Change::EVERYTHING.and(Change::TONE).and(scratch)).unwrap());
    }
    if scene.transport.budget.is_some() {
        session.frame(Change::MATERIAL).unwrap();
        needs.extend(session.needs(Change::MATERIAL).unwrap());
    }
    assert!(session.device().is_some());
    let pipelines: BTreeSet<_> = session.pipelines().into_iter().collect();
    let listed: BTreeSet<_> = needs
        .iter()
        .flat_map(|need| &need.kernels)
        .map(|kernel| KernelKey { name: kernel.name.clone(), constants: kernel.constants.clone() })
        .collect();
    assert_eq!(pipelines, listed, "{}", scene.name);
    let buffers = session.device_buffers();
    assert_eq!(buffers, session.buffers(), "{}", scene.name);
    let planned: Vec<_> = session.plan().stages.iter().map(|stage| stage.name).collect();
    assert!(needs.iter().all(|need| planned.contains(&need.stage)), "{planned:?}");
    assert!(session.plan().left_out.iter().all(|(what, why)| !planned.contains(what) && !why.is_empty()));
    let dispatched = needs.iter().map(|need| (need.stage, need.dispatches)).collect();
    (
        pipelines.into_iter().map(|kernel| kernel.name).collect(),
        buffers.into_iter().map(|(slot, _)| slot).collect(),
        dispatched,
    )
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn what_is_turned_off_is_not_there() {
        let list = features();
        // Every stage belongs to some feature, except `refit`, which every frame runs, and the stages of `eval`.
        for stage in STAGES.iter().filter(|stage| !["refit", "evaluate", "cdrf_values"].contains(&stage.name)) {
            assert!(
                list.iter().any(|(stages, ..)| stages.contains(&stage.name)),
                "no feature has stage {}",
                stage.name
            );
        }
        on_devices(|device| {
            for (stages, slots, on, off) in &list {
                let (with, without) = (made(device, &on.0, on.1), made(device, &off.0, off.1));
                for name in *stages {
                    let folder = format!("{}/{name}", stage(name).unwrap().module);
                    let own = |kernels: &BTreeSet<String>| {
                        kernels
                            .iter()
                            .filter(|kernel| **kernel == folder || kernel.starts_with(&format!("{folder}/")))
                            .count()
                    };
                    let dispatches =
                        |list: &[(&str, usize)]| list.iter().find(|row| row.0 == *name).map_or(0, |row| row.1);
                    assert!(own(&with.0) > 0 && dispatches(&with.2) > 0, "{name} is not there");
                    assert_eq!((own(&without.0), dispatches(&without.2)), (0, 0), "{name} is still there");
                }
                for slot in *slots {
                    assert!(with.1.contains(slot), "{stages:?}: buffer {slot:?} is not there");
                    assert!(!without.1.contains(slot), "{stages:?}: buffer {slot:?} is still there");
                }
            }
        });
    }
}
