//! Spot and area lights against closed forms.

use std::f64::consts::PI;

use glam::DVec3;
use milkglass::internals::pipeline::frame::steps;
use milkglass::internals::pipeline::plan::Change;
use milkglass::scene::{Light, Scene, Source};
use milkglass::{Options, Session};

use super::{CLEAR, irradiance, scene, sheets};

/// Irradiance of one small square in the plane z = 0 at the origin, facing +z, under this light.
fn face(source: Source) -> f64 {
    let mut small = scene("sphere", &["object.0.detail=0", CLEAR]);
    let (a, b) = (1e-3, 2e-3);
    small.objects[0].mesh = sheets(1, &[[DVec3::new(-a, -a, 0.0), DVec3::X * b, DVec3::Y * b]]);
    small.lights = vec![Light { source, shadows: true }];
    let found = irradiance(&small);
    (found[0].x + found[1].x) / 2.0
}

#[test]
fn a_spot_fades_between_its_cones() {
    let spot = |degrees: f64| {
        let away = DVec3::new(degrees.to_radians().sin(), 0.0, -degrees.to_radians().cos());
        face(Source::Spot { position: DVec3::Z * 2.0, direction: away, intensity: [8.0; 3], inner: 20.0, outer: 40.0 })
    };
    for degrees in [0.0, 10.0, 19.9] {
        assert!((spot(degrees) - 2.0).abs() < 1e-5, "{degrees}: {}", spot(degrees));
    }
    for degrees in [25.0f64, 30.0, 35.0] {
        let cos = |degrees: f64| degrees.to_radians().cos();
        let t = (cos(degrees) - cos(40.0)) / (cos(20.0) - cos(40.0));
        let expected = 2.0 * (3.0 * t * t - 2.0 * t * t * t);
        assert!((spot(degrees) - expected).abs() < 2e-3, "{degrees}: {} {expected}", spot(degrees));
    }
    for degrees in [40.1, 90.0, 180.0] {
        assert_eq!(spot(degrees), 0.0, "{degrees}");
    }
}

#[test]
fn a_narrow_beam_lights_all_of_its_cone() {
    let spot = |degrees: f64| {
        let away = DVec3::new(degrees.to_radians().sin(), 0.0, -degrees.to_radians().cos());
        face(Source::Spot { position: DVec3::Z * 2.0, direction: away, intensity: [8.0; 3], inner: 2.0, outer: 2.2 })
    };
    assert!([0.0, 1.0, 1.9].iter().all(|&degrees| (spot(degrees) - 2.0).abs() < 1e-5), "{}", spot(1.9));
    assert_eq!(spot(2.3), 0.0);
}

fn panel(height: f64, edge_u: DVec3, edge_v: DVec3, samples: u32, two_sided: bool) -> Source {
    Source::Area { position: DVec3::Z * height, edge_u, edge_v, radiance: [1.0; 3], two_sided, samples }
}

#[test]
fn an_area_tends_to_the_closed_form() {
    // A square of side 2 at height 1 above the face: four corner rectangles of 1 x 1 at distance 1.
    let (u, v) = (DVec3::Y * 2.0, DVec3::X * 2.0);
    let corner = 2.0 * (0.5f64.sqrt() * 0.5f64.sqrt().atan()) / (2.0 * PI);
    let expected = PI * 4.0 * corner;
    let mut before = f64::INFINITY;
    for samples in [4, 8, 16, 32] {
        let error = (face(panel(1.0, u, v, samples, false)) / expected - 1.0).abs();
        assert!(error < before / 3.0, "{samples}: {error}, before {before}");
        before = error;
    }
    assert!(before < 5e-4, "{before}");
}

#[test]
fn an_area_far_away_is_a_point_and_shines_to_its_side() {
    let (u, v) = (DVec3::Y * 2.0, DVec3::X * 3.0);
    let expected = 6.0 / 1e6;
    for (edge_u, edge_v, both, shines) in [(u, v, false, true), (v, u, false, false), (v, u, true, true)] {
        let found = face(panel(1e3, edge_u, edge_v, 4, both));
        let expected = if shines { expected } else { 0.0 };
        assert!((found - expected).abs() <= 1e-4 * expected, "{found} {expected}");
    }
}

#[test]
fn a_soft_shadow_has_a_penumbra() {
    // A panel above and a plate half way: all dark right under the plate, fully lit far aside, a penumbra in between.
    let floor = [DVec3::new(-4.0, -4.0, 0.0), DVec3::X * 8.0, DVec3::Y * 8.0];
    let plate = [DVec3::new(-1.0, -1.0, 2.0), DVec3::X * 2.0, DVec3::Y * 2.0];
    let mut scene = scene("sphere", &["object.0.detail=0", CLEAR]);
    scene.objects[0].mesh = sheets(16, &[floor, plate]);
    scene.lights = vec![Light { source: panel(4.0, DVec3::Y * 1.5, DVec3::X * 1.5, 8, false), shadows: true }];
    let lights = vec![Light { shadows: false, ..scene.lights[0].clone() }];
    let (shadowed, open) = (irradiance(&scene), irradiance(&Scene { lights, ..scene }));
    let share = |face: usize| shadowed[face].x / open[face].x;
    let shares: Vec<f64> = (0..512).map(share).collect();
    assert!(shares[2 * (8 * 16 + 8)] == 0.0 && shares[0] == 1.0, "{} {}", shares[272], shares[0]);
    assert!(shares.iter().filter(|&&s| s > 0.05 && s < 0.95).count() > 20);
}

/// A triangle whose area vanishes in `f32` has no normal: it receives no light of a direction, and the mean of an
/// environment, which is that of every face if the environment is uniform.
#[test]
fn a_face_without_area_receives_what_needs_no_normal() {
    for (light, share) in [("camera.fov=30", 0.0), ("light=[{ type='environment', radiance=1 }]", 1.0)] {
        let small = scene("sphere", &["object.0.detail=1", light]);
        let mut session = Session::new(&small, None, Options::default()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let mut state = session.state().clone();
        let lit = (0..state.data.irradiance.len()).find(|&face| state.data.irradiance[face][0] > 0.0).unwrap();
        let (before, leaf) = (state.data.irradiance[lit], state.data.leaves[lit] as usize);
        (state.data.clusters[leaf].normal, state.data.clusters[leaf].area) = ([0.0; 3], 0.0);
        steps(&state, |stage, _| stage.name == "irradiance").iter().for_each(|step| step.reference(&mut state));
        for (found, before) in state.data.irradiance[lit].iter().zip(before) {
            assert!((found - share * before).abs() < 1e-5 * before, "{light}: {found}, {before} with an area");
        }
    }
}
