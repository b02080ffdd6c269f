//! The random walk's light, its end, and its photons, as a program sets them.

use super::walk::{Frame, SKY, SUN, balances, cube_of, options, scene};
use crate::devices::on_devices;
use milkglass::Session;
use milkglass::internals::gpu::Device;
use milkglass::internals::session::walk::WalkControl;

#[test]
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
    on_devices_and_cpu(|device| {
        let mut session = Session::new(&cube, device, options()).unwrap();
        let light: Vec<[f64; 3]> = (0..12).map(|face| [if face < 2 { 2.0 } else { 0.0 }; 3]).collect();
        session.walk_from(&light);
        for (k, face) in session.faces_after_a_frame().into_iter().enumerate() {
            // Four hundred free paths do not let it come to the other sides.
            assert_eq!(face.irradiance, light[k]);
            assert!(if k < 2 { face.radiosity[1] > 0.6 } else { face.radiosity[1] < 0.1 }, "{k}: {face:?}");
        }
    });
}

fn on_devices_and_cpu(check: impl Fn(Option<&Device>)) {
    check(None);
    on_devices(|device| check(Some(device)));
}
