//! The random walk's light, its end, and its photons, as a program sets them.

use std::cell::RefCell;

use super::walk::{Frame, SKY, SUN, balances, cube_of, options, scene};
use crate::devices::on_devices;
use milkglass::Session;
use milkglass::internals::gpu::faults::on_altered;
use milkglass::internals::gpu::{Adapter, Device, Instance};
use milkglass::internals::session::walk::{WalkControl, WalkProgress};
use milkglass::measure::truth::Truth;

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_walk_of_a_time_has_no_other_end() {
    let sets = ["object.0.detail=2", "object.0.size=10", SUN, "transport.walks=90"];
    let mut session = Session::new(&scene(&sets), None, options()).unwrap();
    let within = Some(std::time::Duration::from_millis(400));
    session.watch_walk(WalkControl { within, ..WalkControl::default() });
    session.faces_after_a_frame();
    let report = session.walk_reports()[0].clone();
    assert!(report.stopped && report.photons > 90 && report.seconds > 0.39, "{report:?}");
    balances(session.state());
    // Other photons by another seed, the same ones by the same.
    let mut left = |seed: u32| {
        session.watch_walk(WalkControl { seed, ..WalkControl::default() });
        session.faces_after_a_frame();
        session.walk_reports()[0].left
    };
    let (one, two) = (left(0), left(1));
    assert!(one != two && one == left(0));
}

#[test]
fn light_enters_where_it_is_told() {
    let mut cube =
        scene(&[SKY, "object.0.material={ sigma_s_prime = 20, sigma_a = 0.5, eta = 1 }", "transport.walks=600"]);
    cube.objects[0].mesh = cube_of(20.0);
    let lit = |face: usize| [0, 5].contains(&face);
    on_devices_and_cpu(|device| {
        let mut session = Session::new(&cube, device, options()).unwrap();
        let light: Vec<[f64; 3]> = (0..12).map(|face| [if lit(face) { 2.0 } else { 0.0 }; 3]).collect();
        session.walk_from(&light);
        for (k, face) in session.faces_after_a_frame().into_iter().enumerate() {
            // Four hundred free paths do not let it come to the other sides, nor to the other half of its own.
            assert_eq!(face.irradiance, light[k]);
            assert!(if lit(k) { face.radiosity[1] > 0.6 } else { face.radiosity[1] < 0.1 }, "{k}: {face:?}");
        }
    });
}

#[test]
fn a_device_without_round_to_nearest_is_told() {
    let ball = scene(&["object.0.detail=1", SUN]);
    let caveat = |device: &Device, options| Session::new(&ball, Some(device), options).unwrap().walk_caveat();
    on_devices(|device| {
        assert_eq!(caveat(device, options()), None, "{}", device.name());
        let lesser = on_altered(
            |adapter| adapter.limits.round_to_nearest = false,
            || {
                let instance = Instance::open(true).unwrap();
                let adapters = instance.adapters().unwrap();
                Device::open(&instance, Adapter::find(&adapters, device.name()).unwrap()).unwrap()
            },
        );
        let told = caveat(&lesser, options()).unwrap();
        assert!(told.starts_with(device.name()) && told.contains("rounding to nearest"), "{told}");
        assert_eq!(caveat(&lesser, milkglass::Options::default()), None, "of other methods conform speaks");
        // `Truth` tells its listener.
        let control = WalkControl { tell: Some(heard), ..WalkControl::default() };
        HEARD.set(None);
        Truth::walk(&scene(&["object.0.detail=1", SUN, "transport.walks=9"]), Some(&lesser), control).unwrap();
        assert_eq!(HEARD.take(), Some(told));
    });
    assert_eq!(Session::new(&ball, None, options()).unwrap().walk_caveat(), None);
}

thread_local! {
    static HEARD: RefCell<Option<String>> = const { RefCell::new(None) };
}

fn heard(line: &str) {
    HEARD.set(Some(line.to_string()));
}

#[test]
fn a_watched_walk_is_the_same_and_shows_how_far_it_is() {
    thread_local! {
        static SHOWN: RefCell<Vec<Option<WalkProgress>>> = const { RefCell::new(Vec::new()) };
    }
    let sets = ["object.0.detail=1", "object.0.size=4", SUN, "transport.walks=20000"];
    let left = |control| {
        let mut session = Session::new(&scene(&sets), None, options()).unwrap();
        session.watch_walk(control);
        session.faces_after_a_frame();
        (session.walk_reports()[0].photons, session.walk_reports()[0].left)
    };
    let alone = left(WalkControl::default());
    let show = |progress: Option<&WalkProgress>| SHOWN.with_borrow_mut(|all| all.push(progress.copied()));
    // The first photons end before the others start; they are the same ones.
    let watched = WalkControl { tell: Some(|_| ()), show: Some(show), ..WalkControl::default() };
    assert_eq!((alone.0, left(watched)), (20_000, alone));
    let shown = SHOWN.take();
    let so_far: Vec<WalkProgress> = shown.iter().flatten().copied().collect();
    assert_eq!((shown.len(), shown.last()), (so_far.len() + 1, Some(&None)));
    assert!(so_far.windows(2).all(|pair| pair[0].done <= pair[1].done), "{so_far:?}");
    let last = so_far.last().unwrap();
    assert!(so_far.len() > 2 && so_far[0].noise.is_none() && so_far[0].done > 0.3, "{so_far:?}");
    assert!(last.done == 1.0 && last.left == Some(0.0) && last.noise.is_some_and(|x| x < 0.2), "{last:?}");
}

pub(super) fn on_devices_and_cpu(check: impl Fn(Option<&Device>)) {
    check(None);
    on_devices(|device| check(Some(device)));
}
