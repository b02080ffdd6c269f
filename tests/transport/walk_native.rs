//! The random walk beside a plain native program of it, which shares no line with the reference.

use super::walk::{Frame, SUN, options, scene};
use crate::native_walk::Body;
use milkglass::Session;

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn as_much_light_leaves_as_from_a_native_walk() {
    let sets =
        [SUN, "object.0.material.preset=marble", "object.0.size=20", "object.0.detail=2", "transport.walks=8000"];
    let scene = scene(&sets);
    let mut session = Session::new(&scene, None, options()).unwrap();
    let light = session.faces_after_a_frame().iter().map(|face| face.area * face.irradiance[1]).collect();
    let ours = session.walk_reports()[0].left.iter().sum::<f64>() / 3.0;
    let (body, material) = (Body::new(&scene, light, glam::DVec3::Z), &scene.objects[0].material);
    let media = [0, 1, 2].map(|c| (material.sigma_s_prime[c], material.sigma_a[c], material.eta[c]));
    let (native, flights) = body.walk(media, 8000, 1);
    // Of 24,000 photons each: four standard errors of a share.
    assert!((ours - native).abs() < 0.013 && (0.1..0.95).contains(&native), "{ours} {native}");
    assert!(flights > 10.0, "{flights}");
}
