//! Makes every fallible Vulkan call fail: the error is clear, nothing leaks, and later frames are correct.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::devices;
use milkglass::error::{Error, Result};
use milkglass::internals::gpu::faults::{Call, watch};
use milkglass::internals::gpu::{Adapter, Buffer, Choices, Device, Instance, Submissions};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// Calls whose failure is harmless: naming objects for tools, waiting before teardown, listing instance extensions,
/// keeping what a later submission could use.
const HARMLESS: [&str; 5] = [
    "vkSetDebugUtilsObjectNameEXT",
    "vkDeviceWaitIdle",
    "vkEnumerateInstanceExtensionProperties",
    "vkResetFences",
    "vkResetDescriptorPool",
];
/// All other calls of the program with the default choices; `vkAllocateMemory` stands for the allocator's calls,
/// mapping included.
const CALLS: [&str; 22] = [
    "vkAllocateCommandBuffers",
    "vkAllocateDescriptorSets",
    "vkAllocateMemory",
    "vkBeginCommandBuffer",
    "vkBindBufferMemory",
    "vkCreateBuffer",
    "vkCreateCommandPool",
    "vkCreateComputePipelines",
    "vkCreateDebugUtilsMessengerEXT",
    "vkCreateDescriptorPool",
    "vkCreateDescriptorSetLayout",
    "vkCreateDevice",
    "vkCreateFence",
    "vkCreateInstance",
    "vkCreatePipelineCache",
    "vkCreatePipelineLayout",
    "vkCreateQueryPool",
    "vkCreateShaderModule",
    "vkEndCommandBuffer",
    "vkEnumeratePhysicalDevices",
    "vkQueueSubmit",
    "vkWaitForFences",
];

/// All of these, with the call that only devices with timestamps need.
fn expected() -> BTreeSet<&'static str> {
    CALLS.into_iter().chain(HARMLESS).chain(["vkGetQueryPoolResults"]).collect()
}

fn scene(radiosity: bool, light: &str) -> Scene {
    let scheme = if radiosity { "transport.scheme='links'" } else { "transport.scheme='blocks'" };
    let light = format!("light=[{{type='directional',direction=[0,0.6,0.8],irradiance={light}}}]");
    let sets = ["object.0.detail=0", "camera.size=[8,8]", scheme, &light].map(String::from);
    Scene::load_with("sphere", &sets).unwrap()
}

/// One frame of a session: its picture or its radiosity.
fn frame(session: &mut Session) -> Result<Vec<[f32; 3]>> {
    session.frame(Change::EVERYTHING)?;
    if session.plan().options().goal == Goal::Picture {
        return Ok(session.picture()?.pixels);
    }
    session.fetch(&[BufferId::radiosity])?;
    Ok(session.state().data.radiosity.clone())
}

/// A session from scratch to its values; opened objects stay open for inspection.
struct Run {
    session: Option<Session>,
    device: Option<Device>,
    instance: Option<Instance>,
}

impl Run {
    fn new() -> Self {
        Self { session: None, device: None, instance: None }
    }

    fn go(&mut self, scene: &Scene, goal: Goal, name: &str) -> Result<Vec<[f32; 3]>> {
        let instance = self.instance.insert(Instance::open(true)?);
        let adapters = instance.adapters()?;
        let adapter = adapters.iter().find(|a| a.name == name).expect("the device is still there");
        let device = self.device.insert(Device::open(instance, adapter)?);
        let options = Options { goal, ..Options::default() };
        let session = self.session.insert(Session::new(scene, Some(device), options)?);
        frame(session)
    }

    /// Closes everything; nothing may be leaked.
    fn close(&mut self, what: &str) {
        self.session = None;
        if let Some(device) = self.device.take() {
            assert_eq!(device.allocations(), [""; 0], "{what}");
        }
        let messages = self.instance.take().map(|instance| instance.take_messages()).unwrap_or_default();
        assert!(messages.is_empty(), "{what}: {}", messages.join("\n"));
    }
}

/// The index of the last call of each name and purpose.
fn each_once(calls: &[Call]) -> Vec<usize> {
    let last = |(k, call): &(usize, &Call)| !calls[k + 1..].contains(call);
    calls.iter().enumerate().filter(last).map(|(k, _)| k).collect()
}

/// After a failed frame, or a failed change before it, a session's next frame is correct to the last bit.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_session_survives() {
    devices::on_devices(|device| {
        for radiosity in [false, true] {
            let (first, second) = (scene(radiosity, "2"), scene(radiosity, "[3,0.5,0.25]"));
            let options =
                Options { goal: if radiosity { Goal::Radiosity } else { Goal::Picture }, ..Options::default() };
            let open = |scene| Session::new(scene, Some(device), options).unwrap();
            let right = [frame(&mut open(&first)).unwrap(), frame(&mut open(&second)).unwrap()];
            assert_ne!(right[0], right[1]);

            // On a separate device, whose kernels are not built yet.
            let instance = Instance::open(true).unwrap();
            let adapter = instance.adapters().unwrap().into_iter().find(|a| a.name == device.name()).unwrap();
            // One that records each frame anew: a recording that is used again has few calls that can fail.
            let anew = Choices { submissions: Submissions::Frame, ..Choices::default() };
            let fresh = Device::open_as(&instance, &adapter, &anew).unwrap();
            let mut session = Session::new(&first, Some(&fresh), options).unwrap();
            let next = |session: &mut Session, turn: usize| {
                session.show([&first, &second][turn % 2])?;
                frame(session)
            };
            // The second frame finds all kernels made, as further ones do; naming an object may fail without harm.
            watch(None, || next(&mut session, 1).unwrap());
            let (_, calls) = watch(None, || next(&mut session, 2).unwrap());
            let harmful: Vec<usize> = (0..calls.len()).filter(|k| !HARMLESS.contains(&calls[*k].name)).collect();
            // Some of all calls, and one of each name and purpose.
            let some = harmful.iter().copied().step_by(harmful.len().div_ceil(40));
            let once = each_once(&calls).into_iter().filter(|k| harmful.contains(k));
            let mut failed = 0;
            for (k, turn) in some.chain(once).collect::<BTreeSet<_>>().into_iter().zip(3..) {
                let (done, _) = watch(Some(k), || next(&mut session, turn));
                failed += usize::from(done.is_err());
                assert_eq!(frame(&mut session).unwrap(), right[turn % 2], "after {k}: {:?}", calls[k]);
            }
            assert!(failed > 20, "{failed}");
            assert_eq!(instance.take_messages(), [""; 0]);
        }
    });
}

/// Frames before a failing one are whole, no partial file stays, and a second run resumes.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_sequence_is_whole_as_far_as_it_goes() {
    let here = tempfile::tempdir().unwrap();
    devices::on_devices(|device| {
        let render = |name: &str, more: &[&str]| {
            let output = here.path().join(name);
            let fixed =
                ["milkglass", "render", "noise", "--frames", "0..3", "--size", "12x8", "-o", output.to_str().unwrap()];
            let sets = ["--set", "object.0.detail=2", "--device", device.name()];
            let words = fixed.iter().chain(&sets).chain(more);
            milkglass::cli::run(words.map(Into::into))
        };
        let read = |name: &str, k: usize| std::fs::read(here.path().join(format!("{name}{k}.png"))).ok();
        let (done, calls) = watch(None, || render("whole%d.png", &[]));
        done.unwrap();
        // Submissions of frames; there is at least one per frame.
        let frames: Vec<usize> = (0..calls.len()).filter(|&k| calls[k].doing.starts_with("running a frame")).collect();
        for (turn, share) in [(0, 3), (1, 2), (2, 1)] {
            let k = frames[frames.len() - 1 - frames.len() * share / 4];
            let name = format!("part{turn}-");
            let (done, _) = watch(Some(k), || render(&format!("{name}%d.png"), &[]));
            assert_eq!(done.unwrap_err().exit_code(), 3);
            let there: Vec<usize> = (0..4).filter(|&n| read(&name, n).is_some()).collect();
            assert!(there.len() < 4 && there == (0..there.len()).collect::<Vec<_>>(), "{there:?}");
            assert!(turn == 0 || !there.is_empty());
            render(&format!("{name}%d.png"), &["--skip-existing"]).unwrap();
            (0..4).for_each(|n| assert!(read(&name, n).is_some() && read(&name, n) == read("whole", n), "{name}{n}"));
            // Those of a film have a file of their own.
            watch(Some(k), || render(&format!("{turn}.gif"), &[])).0.unwrap_err();
            let film = here.path().join(format!("{turn}.0-{}.gif", there.len().saturating_sub(1)));
            assert!(film.exists() != there.is_empty() && !here.path().join(format!("{turn}.gif")).exists());
        }
        let names = std::fs::read_dir(here.path()).unwrap().map(|entry| entry.unwrap().file_name());
        assert!(names.into_iter().all(|name| !name.to_string_lossy().contains("part.")));
    });
}

/// Waiting for a submission times out, and a late submission is still freed.
#[test]
fn a_wait_ends() {
    devices::on_devices(|device| {
        device.wait_at_most(Duration::from_nanos(1));
        let scene = scene(false, "2");
        let error = Session::new(&scene, Some(device), Options::default()).and_then(|mut session| frame(&mut session));
        let text = error.unwrap_err().to_string();
        assert!(text.contains("not finished in time") && text.contains("MILKGLASS_TIMEOUT"), "{text}");
        device.wait_at_most(Duration::from_secs(600));
        let mut session = Session::new(&scene, Some(device), Options::default()).unwrap();
        assert!(frame(&mut session).unwrap().iter().flatten().any(|&x| x > 0.0));
        drop(session);
        assert_eq!(device.allocations(), [""; 0]);
    });
}

/// Running out of device memory is an error that names the buffer.
#[test]
fn a_driver_without_memory_says_so() {
    devices::on_devices(|device| {
        let instance = Instance::open(true).unwrap();
        let mut adapter: Adapter =
            instance.adapters().unwrap().into_iter().find(|adapter| adapter.name == device.name()).unwrap();
        let most = adapter.limits.allocation_bytes;
        let said = Buffer::new(device, "large", most + 1).err().unwrap().to_string();
        assert!(said.contains("buffer large") && said.contains(&most.to_string()), "{said}");
        // With the limit raised, the driver itself has to refuse.
        adapter.limits.allocation_bytes = u64::MAX;
        let trusting = Device::open(&instance, &adapter).unwrap();
        if let Err(error) = Buffer::new(&trusting, "huge", 1 << 44) {
            assert!(error.to_string().contains("buffer huge"), "{error}");
        }
        assert_eq!(trusting.allocations(), [""; 0]);
    });
}

mod rare {
    use super::*;

    /// Every failing call gives an error that names call and remedy, and leaves nothing behind.
    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn every_call_may_fail() {
        devices::on_devices(|device| {
            let (mut known, mut tried) = (BTreeSet::new(), BTreeSet::new());
            for goal in [Goal::Picture, Goal::Radiosity] {
                let scene = scene(goal == Goal::Radiosity, "2");
                let mut run = Run::new();
                let (whole, calls) = watch(None, || {
                    let values = run.go(&scene, goal, device.name()).unwrap();
                    run.close("whole");
                    values
                });
                known.extend(calls.iter().map(|call| call.name));
                // Calls that both goals share fail only under the first.
                let untried = |k: &usize| tried.insert((calls[*k].name, calls[*k].doing.clone()));
                let chosen: Vec<usize> = each_once(&calls).into_iter().filter(untried).collect();
                println!("{}, {goal:?}: {} calls, {} of them made to fail", device.name(), calls.len(), chosen.len());
                for &k in &chosen {
                    let what = format!("{k}: {:?}", calls[k]);
                    let (done, _) = watch(Some(k), || {
                        let done = run.go(&scene, goal, device.name());
                        done.inspect(|_| run.close(&what))
                    });
                    match done {
                        Ok(values) => {
                            assert!(HARMLESS.contains(&calls[k].name), "{what} did not fail");
                            assert_eq!(values, whole, "{what}");
                        }
                        Err(error) => {
                            let text = error.to_string();
                            assert!(matches!(error, Error::Device { .. }) && error.exit_code() == 3, "{what}: {text}");
                            assert!(
                                text.starts_with(&calls[k].doing) && text.contains(calls[k].name),
                                "{what}: {text}"
                            );
                            assert!(
                                ["use ", "install ", "run "].iter().any(|word| text.contains(word)),
                                "{what}: {text}"
                            );
                            run.close(&what);
                        }
                    }
                }
                // A fresh run gives the same values.
                assert_eq!(run.go(&scene, goal, device.name()).unwrap(), whole);
                run.close("fresh");
            }
            let timed = device.limits().timestamp_period > 0.0;
            assert_eq!(known, expected().into_iter().filter(|name| timed || !name.contains("Quer")).collect());
        });
    }
}
