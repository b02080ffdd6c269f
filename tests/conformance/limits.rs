//! Devices with lower limits: work is split to fit, done differently with a message, or refused by name. The limits are
//! lowered on a real device.

use std::time::Duration;

use super::variants::some;
use crate::devices::on_devices;
use crate::shell;
use milkglass::internals::gpu::faults::on_altered;
use milkglass::internals::gpu::{Adapter, Choices, Device, Instance, Limits, accesses, kernel_names};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options};
use milkglass::internals::session::run::{CapacityHints, Session};
use milkglass::measure::conform::conform;
use milkglass::scene::Scene;

fn scene(scheme: &str) -> Scene {
    let sets = ["object.0.detail=3".into(), "camera.size=[48,32]".into(), format!("transport.scheme='{scheme}'")];
    Scene::load_with("sphere", &sets).unwrap()
}

/// The same device with other limits.
fn lowered(device: &Device, instance: &Instance, lower: impl Fn(&mut Limits)) -> Device {
    let mut adapter = instance.adapters().unwrap().into_iter().find(|adapter| adapter.name == device.name()).unwrap();
    lower(&mut adapter.limits);
    Device::open(instance, &adapter).unwrap()
}

/// Renders a picture; returns it with its session.
fn render(scene: &Scene, device: &Device, mode: Mode) -> Result<(Session, Vec<[f32; 3]>), String> {
    let options = Options { mode, goal: Goal::Picture, ..Options::default() };
    let shown = Session::new(scene, Some(device), options).and_then(|mut session| {
        session.frame(Change::EVERYTHING)?;
        let pixels = session.picture()?.pixels;
        Ok((session, pixels))
    });
    shown.map_err(|error| error.to_string())
}

/// Runs a check with each device and a validating instance for lowered ones; that instance must report no messages.
fn with(body: impl Fn(&Device, &Instance)) {
    on_devices(|device| {
        let instance = Instance::open(true).unwrap();
        body(device, &instance);
        let messages = instance.take_messages();
        assert!(messages.is_empty(), "{}", messages.join("\n"));
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_smaller_binding_cuts_the_lists() {
    with(|device, instance| {
        for scheme in ["blocks", "links"] {
            let mut scene = scene(scheme);
            // A tight tolerance, so that the lists are larger than the buffers that cannot be split.
            scene.transport.tolerance = 1e-5;
            let (whole, picture) = render(&scene, device, Mode::OnTheFly).unwrap();
            // The least size that the buffers that cannot be split need.
            let lists = [
                BufferId::entries,
                BufferId::decisions,
                BufferId::links,
                BufferId::factors,
                BufferId::area_links,
                BufferId::edge_links,
                BufferId::handed,
            ];
            let other = whole.buffers().into_iter().filter(|(slot, _)| !lists.contains(slot));
            let most = other.map(|(_, bytes)| bytes).max().unwrap();
            let small = lowered(device, instance, |limits| limits.binding_bytes = most);
            let (cut, same) = render(&scene, &small, Mode::OnTheFly).unwrap();
            let parts = |session: &Session| {
                session.state().sum(|object| object.schedule.chunks.len() + object.schedule.batches.len())
            };
            assert!(parts(&cut) > parts(&whole), "{scheme}: {} parts as before", parts(&whole));
            assert_eq!(same, picture, "{scheme}");
            assert!(cut.misfits(Change::EVERYTHING).unwrap().is_empty());
        }
    });
}

#[test]
fn a_binding_too_small_is_refused_by_the_buffers_name() {
    with(|device, instance| {
        let small = lowered(device, instance, |limits| limits.binding_bytes = 1 << 13);
        let said = render(&scene("blocks"), &small, Mode::OnTheFly).err().unwrap();
        assert!(said.contains("buffer ") && said.contains("at most 8192") && said.contains("--device cpu"), "{said}");
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn fewer_groups_make_more_rows() {
    with(|device, instance| {
        for scheme in ["blocks", "links"] {
            let scene = scene(scheme);
            let (_, picture) = render(&scene, device, Mode::OnTheFly).unwrap();
            let narrow = lowered(device, instance, |limits| limits.groups = [7, 65535]);
            assert_eq!(render(&scene, &narrow, Mode::OnTheFly).unwrap().1, picture, "{scheme}");
            let none = lowered(device, instance, |limits| limits.groups = [2, 2]);
            let said = render(&scene, &none, Mode::OnTheFly).err().unwrap();
            assert!(said.contains("recording kernel") && said.contains("at most 2 x 2"), "{said}");
        }
    });
}

#[test]
fn what_is_kept_fits_the_memory_of_the_scene() {
    let mut scene = scene("links");
    let options = Options { mode: Mode::Render, goal: Goal::Radiosity, ..Options::default() };
    let kept = |scene: &Scene| Session::new(scene, None, options).unwrap().not_kept().is_none();
    assert!(kept(&scene));
    scene.memory.limit = scene.memory.taken + 3_000_000;
    assert!(!kept(&scene));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn links_too_many_to_keep_are_made_for_each_frame() {
    with(|device, instance| {
        for scheme in ["blocks", "links"] {
            let scene = scene(scheme);
            let (_, picture) = render(&scene, device, Mode::OnTheFly).unwrap();
            // Small capacities, so that the frame itself discovers what the lists need.
            let little = CapacityHints { links: 40, ..CapacityHints::default() };
            let options = Options { mode: Mode::Render, goal: Goal::Picture, ..Options::default() };
            let mut kept = Session::with_capacity(&scene, Some(device), options, little).unwrap();
            kept.frame(Change::EVERYTHING).unwrap();
            assert!(kept.not_kept().is_none() && kept.retries() > 0);
            let bytes =
                |slot: BufferId| kept.buffers().into_iter().find(|(known, _)| *known == slot).map_or(0, |b| b.1);
            let lists = bytes(BufferId::entries).max(bytes(BufferId::links));
            let all: u64 = kept.buffers().iter().map(|(_, bytes)| bytes).sum();
            // Too much to keep, by list size as known beforehand, by list size as found in the frame, and by memory;
            // on-the-fly needs less memory with blocks only.
            let mut cases = vec![("few", 64, u64::MAX), ("some", lists - 64, u64::MAX)];
            cases.extend((scheme == "blocks").then_some(("heap", u64::MAX, all - 64)));
            for (name, most, heap) in cases {
                let small = lowered(device, instance, |limits| limits.heap_bytes = heap.min(limits.heap_bytes));
                for mode in [Mode::Render, Mode::Incremental] {
                    let options = Options { mode, goal: Goal::Picture, ..Options::default() };
                    let room = CapacityHints { kept: most, ..little };
                    let mut session = Session::with_capacity(&scene, Some(&small), options, room).unwrap();
                    assert_eq!(session.not_kept().is_some(), name == "few", "{scheme} {name}");
                    session.frame(Change::EVERYTHING).unwrap();
                    assert!(session.picture().unwrap().pixels == picture, "{scheme} {name} {mode:?}");
                    let why = session.not_kept().expect("too much to keep").to_string();
                    assert!(why.contains("on-the-fly"), "{why}");
                    assert!(session.plan().left_out.iter().any(|(what, known)| *what == "kept links" && *known == why));
                    // The next frame has the same picture.
                    session.frame(Change::LIGHT).unwrap();
                    assert!(session.picture().unwrap().pixels == picture, "{scheme} {name} {mode:?}");
                }
            }
            // A mode that reports links cannot run without them.
            let room = CapacityHints { kept: 64, ..CapacityHints::default() };
            let options = Options { mode: Mode::Keep, ..Options::default() };
            let said = Session::with_capacity(&scene, Some(device), options, room).err().unwrap().to_string();
            assert!(said.contains("keeping lists") && said.contains("--aov"), "{said}");
        }
    });
}

#[test]
fn kernels_bind_no_more_buffers_than_devices_have() {
    // Metal has 31 for all kinds, some drivers for it 16 for storage; one more is bound where a kernel counts its work.
    let most = kernel_names().map(|name| (accesses(name).unwrap().len() + 1, name)).max().unwrap();
    assert!(most.0 <= 16 && most.0 > 8, "{most:?}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_frame_that_takes_long_is_several_submissions() {
    with(|device, instance| {
        let scene = scene("blocks");
        let frames = |kind: &'static str, longest: Duration| {
            let mut adapter =
                instance.adapters().unwrap().into_iter().find(|adapter| adapter.name == device.name()).unwrap();
            adapter.kind = kind;
            let device =
                Device::open_as(instance, &adapter, &Choices { lanes: Some(1), ..Choices::default() }).unwrap();
            device.cut_at(longest);
            let options = Options { mode: Mode::OnTheFly, goal: Goal::Picture, ..Options::default() };
            let mut session = Session::new(&scene, Some(&device), options).unwrap();
            let counts = [0; 3].map(|_| {
                let before = device.submissions();
                session.frame(Change::EVERYTHING).unwrap();
                device.submissions() - before
            });
            let dispatches = session.dispatches(Change::EVERYTHING).unwrap();
            let mut stages: Vec<_> = dispatches.iter().map(|dispatch| (dispatch.stage, dispatch.at)).collect();
            stages.dedup();
            (counts, stages.len() as u64, dispatches.len() as u64, session.picture().unwrap().pixels)
        };
        let hour = Duration::from_secs(3600);
        let (whole, _, _, picture) = frames("cpu", hour);
        // Before their times are known, steps are submitted one by one.
        let (first, steps, _, same) = frames("discrete", hour);
        assert!(first[0] >= whole[0] + steps - 1 && first[2] == whole[2] && same == picture, "{first:?}, {whole:?}");
        // Of steps that take longer than a submission should each dispatch is one.
        let (cut, _, dispatches, same) = frames("discrete", Duration::from_nanos(1));
        assert!(cut[2] + 1 >= whole[2] + dispatches && same == picture, "{cut:?}, {whole:?}, {dispatches} dispatches");
    });
}

/// A device that has what each has to have, in groups that share items, and says that its subgroups are so large.
fn clamped<const SUBGROUP: u32>(adapter: &mut Adapter) {
    adapter.kind = "discrete";
    let limits = &mut adapter.limits;
    limits.subgroup_size = SUBGROUP;
    limits.group_invocations = 128;
    limits.binding_bytes = limits.binding_bytes.min(128 << 20);
    (limits.storage_buffers, limits.push_bytes) = (16, 128);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn fixtures_conform_within_the_least_limits() {
    let fixtures = some();
    with(|device, instance| {
        let adapter = |alter: fn(&mut Adapter)| {
            let adapters = on_altered(alter, || instance.adapters().unwrap());
            adapters.into_iter().find(|adapter| adapter.name == device.name()).unwrap()
        };
        // Subgroups that are said to be larger than groups of 64, and each size that can be had.
        let sizes = [4, 8, 16, 32, 64, 128].map(|size| Choices { subgroup: Some(size), ..Choices::default() });
        let asked = sizes.into_iter().map(|choices| (adapter(clamped::<8>), choices));
        let cases = [(adapter(clamped::<8>), Choices::default()), (adapter(clamped::<128>), Choices::default())]
            .into_iter()
            .chain(asked.filter(|(adapter, choices)| adapter.offers.lack(choices).is_none()));
        for (turn, (adapter, choices)) in cases.enumerate() {
            let small = Device::open_as(instance, &adapter, &choices).unwrap();
            for fixture in fixtures.iter().skip(turn % 2).step_by(2) {
                let rows = conform(&small, fixture, &[]).unwrap();
                let faults: Vec<&String> = rows.iter().flat_map(|row| &row.faults).collect();
                let (said, size) = (adapter.limits.subgroup_size, choices.subgroup);
                assert!(!rows.is_empty() && faults.is_empty(), "{}, {said}, {size:?}: {faults:?}", fixture.name);
            }
        }
    });
}

/// The result of a command with every device modified by `alter`.
fn altered(device: &Device, line: &str, alter: fn(&mut Adapter)) -> Result<(), (u8, String)> {
    let words = line.split_whitespace().chain(["--device", device.name()]).map(Into::into);
    on_altered(alter, || milkglass::cli::run(words)).map_err(|error| (error.exit_code(), error.to_string()))
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn commands_say_what_a_device_lacks() {
    on_devices(|device| {
        let here = shell::folder(&[]);
        let (json, line) = (
            here.path().join("p.json"),
            "milkglass plan sphere --set object.0.detail=4 --set camera.size=[48,32] --mode render",
        );
        let plan = format!("{line} --json {}", json.display());
        let read = || std::fs::read_to_string(&json).unwrap();
        let told = |text: &str, word: &str| assert!(text.contains(word), "no {word:?} in {text}");

        altered(device, &plan, |_| {}).unwrap();
        told(&read(), "\"too_large\": []");
        altered(device, &plan, |adapter| adapter.limits.binding_bytes = 1 << 15).unwrap();
        told(&read(), "\"clusters\"");
        altered(device, &plan, |adapter| adapter.limits.heap_bytes = 1 << 14).unwrap();
        told(&read(), "kept links");
        let links = plan.replace("--mode", "--set transport.scheme='links' --mode");
        altered(device, &links, |_| {}).unwrap();
        assert!(!read().contains("kept links"));
        altered(device, &links, |adapter| adapter.limits.allocation_bytes = 3 << 20).unwrap();
        told(&read(), "kept links");
        for (name, alter, word) in [
            ("buffers", (|a| a.limits.storage_buffers = 2) as fn(&mut Adapter), "the device allows 2"),
            ("push", |a| a.limits.push_bytes = 0, "bytes of push constants, the device allows 0"),
            ("group", |a| a.limits.group_invocations = 16, "invocations in a group, the device allows 16"),
            ("feature", |a| a.unusable = Some("lacks the feature scalarBlockLayout".into()), "scalarBlockLayout"),
        ] {
            let output = here.path().join("a.png");
            let line = "milkglass render noise --size 8x8 --set object.0.detail=1 -o";
            let (code, text) = altered(device, &format!("{line} {}", output.display()), alter).unwrap_err();
            assert_eq!(code, 3, "{name}");
            told(&text, word);
            assert!(!output.exists());
        }
    });
}
