//! A long run of small frames with changing light, material and shape: memory stays constant, and pictures stay
//! correct.
//!
//! 200 frames, or `MILKGLASS_SOAK_FRAMES=10000 cargo test --release --test soak -- --nocapture`.

use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Mode, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// Frames after which memory should be constant: every material and shape has occurred.
const WARM: usize = 100;

/// The scene of a frame: new light every frame, new shape every fourth, new material every twentieth.
fn scene(frame: usize) -> Scene {
    let angle = 0.37 * frame as f64;
    let presets = ["marble", "ketchup", "skin1"];
    let sets = [
        "object.0.detail=2".to_string(),
        "camera.size=[24,16]".into(),
        format!(
            "light=[{{type='directional',direction=[{:.6},0.5,{:.6}],irradiance={}}}]",
            angle.sin(),
            angle.cos(),
            1 + frame % 7
        ),
        format!("object.0.material.preset='{}'", presets[frame / 20 % presets.len()]),
        format!("object.0.deform=[{{type='twist',angle={}}}]", 5 * (frame / 4 % 9) + 1),
        format!("transport.scheme='{}'", ["blocks", "links"][frame / 60 % 2]),
    ];
    Scene::load_with("sphere", &sets).unwrap()
}

/// Resident memory of the process in bytes; `None` where the system does not report it.
fn resident() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    text.split_whitespace().nth(1)?.parse::<u64>().ok().map(|pages| pages * 4096)
}

/// Runs `frames` frames; checks memory throughout, and some pictures against a fresh session.
fn soak(frames: usize) {
    let Some(device) = Device::best().ok().flatten() else {
        assert!(std::env::var_os("MILKGLASS_NO_DEVICE").is_some(), "no usable Vulkan device");
        println!("WAIVED by MILKGLASS_NO_DEVICE: no usable device");
        return;
    };
    let options = Options { mode: Mode::Render, ..Options::default() };
    let open = |scene: &Scene| Session::new(scene, Some(&device), options).unwrap();
    let mut session = open(&scene(0));
    let (mut warm, mut most, mut peak) = (None, 0, 0);
    for frame in 0..frames {
        session.show(&scene(frame)).unwrap();
        session.frame(Change::default()).unwrap();
        let picture = session.picture().unwrap();
        assert!(picture.pixels.iter().flatten().any(|&x| x > 0.0), "frame {frame} is black");
        if frame + 1 == WARM {
            warm = resident();
            device.forget_peak();
            peak = device.memory().peak;
        } else if frame >= WARM {
            most = most.max(resident().unwrap_or(0));
        }
        // Seven frames spread over the run, and the last.
        if frame % (frames / 7) == frames / 9 || frame + 1 == frames {
            let mut fresh = open(&scene(frame));
            fresh.frame(Change::EVERYTHING).unwrap();
            assert_eq!(picture.pixels, fresh.picture().unwrap().pixels, "frame {frame} has drifted");
        }
    }
    let held = device.memory();
    drop(session);
    assert_eq!(device.allocations(), [""; 0]);
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    if let Some(warm) = warm {
        println!(
            "{frames} frames on {}: {:.1} MiB resident after {WARM}, at most {:.1} after that; device {:.2} MiB now, {:.2} at most",
            device.name(),
            mega(warm),
            mega(most),
            mega(held.allocated),
            mega(held.peak)
        );
        // Allows for fragmentation by allocators and driver caches, but not for 0.01 MiB per frame over a long run.
        assert!(most < warm + (48 << 20), "{:.1} MiB, then {:.1}", mega(warm), mega(most));
    }
    assert!(held.peak < peak.max(1) + (64 << 20), "{held:?} after {peak}");
}

#[test]
fn frames_leave_memory_as_it_was() {
    let frames = std::env::var("MILKGLASS_SOAK_FRAMES").map_or(200, |frames| frames.parse().unwrap());
    soak(frames);
}
