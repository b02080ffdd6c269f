//! Form factors within a budget: how many wait after motion or another material, and that later frames compute them.

use super::incremental::{at, links, open, radiosity, step};
use crate::devices;
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Mode};
use milkglass::internals::session::run::{CapacityHints, Session};

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_budget_is_kept_and_what_waits_is_made_up_for() {
    let check = |device: Option<&Device>| {
        let budget = 2000;
        let sets = ["object.0.detail=16", "transport.budget=2000"];
        let frame = |k: usize| at("bump", &sets, 20.0 + k as f64);
        let mut session = open(&frame(0), device, Mode::Incremental, CapacityHints::default());
        for k in 1..=5 {
            step(&mut session, &frame(k));
            assert!(session.renewed() <= budget, "{} form factors", session.renewed());
        }
        let mut fresh = open(&frame(5), device, Mode::Keep, CapacityHints::default());
        let wanted = radiosity(&mut fresh);
        let error = |session: &mut Session| {
            let has = radiosity(session);
            let far: f64 =
                has.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            (far / wanted.iter().flatten().map(|b| f64::from(*b).powi(2)).sum::<f64>()).sqrt()
        };
        let (waiting, first) = (session.waiting(), error(&mut session));
        assert!(waiting > 3 * budget && first > 1e-3, "{waiting} wait, error {first}");
        let mut frames = 0;
        while session.waiting() > 0 {
            session.frame(Change::default()).unwrap();
            assert!(session.renewed() > 0 && session.renewed() <= budget);
            frames += 1;
        }
        assert_eq!(frames, waiting.div_ceil(budget), "{waiting} waited");
        assert!(radiosity(&mut session) == wanted, "error {} of {first}", error(&mut session));
        // After that, nothing is left to do.
        let none = session.frame(Change::default()).unwrap();
        assert!(none.is_empty() && session.renewed() == 0, "{}", none.len());
        println!("{waiting} waited with an error of {first:.1e}, and were made in {frames} frames");
    };
    check(None);
    devices::on_devices(|device| check(Some(device)));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn another_material_retags_form_factors_within_the_budget() {
    let check = |device: Option<&Device>| {
        let budget = 30_000;
        let soaked = |scale: &str| {
            at(
                "sphere",
                &["object.0.detail=3", "transport.budget=30000", &format!("object.0.material.scale={scale}")],
                0.0,
            )
        };
        let mut session = open(&soaked("1"), device, Mode::Incremental, CapacityHints::default());
        let before = links(&mut session);
        let count: usize = before.iter().map(Vec::len).sum();
        let ran = step(&mut session, &soaked("2"));
        assert!(
            ["refine", "update_links", "refit", "shadow"].iter().all(|idle| !ran.iter().any(|name| name == idle)),
            "{ran:?}"
        );
        assert_eq!(session.renewed(), budget);
        assert_eq!(session.waiting(), count as u64 - budget);
        while session.waiting() > 0 {
            session.frame(Change::default()).unwrap();
            assert!(session.renewed() <= budget);
        }
        let mut fresh = open(&soaked("2"), device, Mode::Keep, CapacityHints::default());
        assert!(radiosity(&mut fresh) == radiosity(&mut session));
        // Links stay, their form factors do not.
        let after = links(&mut session);
        let emitters = |links: &[Vec<(u32, [u32; 3])>]| links.iter().flatten().map(|link| link.0).collect::<Vec<_>>();
        assert!(emitters(&before) == emitters(&after) && before != after);
    };
    check(None);
    devices::on_devices(|device| check(Some(device)));
}
