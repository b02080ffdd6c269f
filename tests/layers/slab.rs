//! The closed forms of a flat slab, and the march through layers against them.

use glam::DVec3;
use milkglass::internals::layers::beneath::phase;
use milkglass::internals::layers::slab::{Lamp, SlabLayer, radiance};
use milkglass::internals::pipeline::plan::Options;
use milkglass::internals::session::run::Session;

use super::{scene, session};

const SKIN: [SlabLayer; 3] = [
    SlabLayer { sigma_s: 2.0, sigma_t: 2.6, g: 0.25, thickness: 0.3 },
    SlabLayer { sigma_s: 6.0, sigma_t: 6.6, g: -0.4, thickness: 0.1 },
    SlabLayer { sigma_s: 1.0, sigma_t: 1.5, g: 0.8, thickness: 1.7 },
];

/// Radiance of the slab by midpoint steps of equal length along the view ray.
fn marched(layers: &[SlabLayer], lamp: Lamp, eye: DVec3, steps: u32) -> f64 {
    let total: f64 = layers.iter().map(|layer| layer.thickness).sum();
    let tau = |depth: f64| {
        let mut top = 0.0;
        layers.iter().fold(0.0, |sum, layer| {
            let part = (depth - top).clamp(0.0, layer.thickness);
            top += layer.thickness;
            sum + layer.sigma_t * part
        })
    };
    let step = total / f64::from(steps);
    (0..steps)
        .map(|i| {
            let depth = (f64::from(i) + 0.5) * step;
            let mut bottom = 0.0;
            let layer = layers.iter().find(|layer| {
                bottom += layer.thickness;
                depth < bottom
            });
            let layer = layer.unwrap();
            let place = -eye * (depth / eye.z);
            let (toward, arrives) = match lamp {
                Lamp::Directional(toward, irradiance) => (toward, irradiance),
                Lamp::Point(at, intensity) => ((at - place).normalize(), intensity / at.distance_squared(place)),
            };
            let dimmed = (-tau(depth) * (1.0 / toward.z + 1.0 / eye.z)).exp();
            layer.sigma_s * phase(false, layer.g, toward.dot(eye)) * arrives * dimmed * step / eye.z
        })
        .sum()
}

#[test]
fn closed_forms_are_what_a_fine_march_gives() {
    let eye = DVec3::new(0.3, -0.5, 0.8).normalize();
    let near = DVec3::new(0.4, 0.1, 0.2);
    let lamps = [
        Lamp::Directional(DVec3::new(-0.6, 0.2, 0.4).normalize(), 3.0),
        Lamp::Point(DVec3::new(2.0, 1.0, 4.0), 50.0),
        Lamp::Point(near, 0.1),
    ];
    for lamp in lamps {
        for layers in [&SKIN[..], &SKIN[..1], &SKIN[1..]] {
            let (found, expected) = (radiance(layers, lamp, eye), marched(layers, lamp, eye, 400_000));
            assert!((found / expected - 1.0).abs() < 1e-5, "{lamp:?}: {found}, not {expected}");
        }
    }
    // One deep layer: sigma_s p E / (sigma_t (mu_i + mu_o)) mu_i.
    let deep = [SlabLayer { sigma_s: 2.0, sigma_t: 4.0, g: 0.0, thickness: 1e3 }];
    let expected = 2.0 / (4.0 * std::f64::consts::PI) * 0.5 / (4.0 * (0.5 + 0.8));
    let toward = DVec3::new(0.75f64.sqrt(), 0.0, 0.5);
    let found = radiance(&deep, Lamp::Directional(toward, 1.0), DVec3::new(0.0, 0.6, 0.8));
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    let far = radiance(&deep, Lamp::Point(toward * 1e6, 1e12), DVec3::new(0.0, 0.6, 0.8));
    assert!((far / expected - 1.0).abs() < 1e-5, "{far} {expected}");
    // A layer without extinction, and a layer without thickness.
    let clear = [SlabLayer { sigma_s: 0.0, sigma_t: 0.0, g: 0.0, thickness: 1.0 }];
    assert_eq!(radiance(&clear, Lamp::Directional(toward, 1.0), eye), 0.0);
    let thin = [SlabLayer { thickness: 0.0, ..SKIN[0] }];
    assert_eq!(radiance(&thin, Lamp::Point(near, 1.0), eye), 0.0);
}

/// A session of these layers on an open square facing +y.
fn flat(light: &str, samples: u32, more: &str) -> Session {
    let layer = |layer: &SlabLayer| {
        let SlabLayer { sigma_s, sigma_t, g, thickness } = layer;
        format!("{{ sigma_s = {sigma_s}, sigma_t = {sigma_t}, g = {g}, thickness = {thickness} }}")
    };
    let layers = SKIN.iter().map(layer).collect::<Vec<_>>().join(", ");
    let sets = [
        "camera={ position = [10.0, 18.0, 14.0], target = [0.0, 0.0, 0.0], size = [17, 13], fov = 12 }".to_string(),
        format!("light=[{light}]"),
        "object.0.shape=plane".to_string(),
        "object.0.size=40".to_string(),
        format!("object.0.material={{ layers = {{ samples = {samples}, layer = [{layers}] {more} }} }}"),
    ];
    session(&scene("slab-layers", &sets.each_ref().map(String::as_str)), Options::default())
}

/// The largest relative error of a picture's pixels against the closed form, and their mean ratio.
fn error(session: &mut Session, lamp: impl Fn(DVec3) -> Lamp) -> (f64, f64) {
    let up = |v: DVec3| DVec3::new(v.x, -v.z, v.y);
    let picture = session.picture().unwrap();
    let (state, units, scene) = (session.state(), session.units(), session.scene());
    let (mut worst, mut ratio) = (0f64, 0.0);
    for (pixel, hit) in picture.pixels.iter().zip(&state.data.hits) {
        let corners = state.data.triangles[hit.face as usize].map(|v| state.data.positions[v as usize]);
        let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let place: DVec3 =
            corners.iter().zip(weight).map(|(p, w)| DVec3::from_array(p.map(f64::from)) * f64::from(w)).sum();
        let place = units.outside(place);
        let eye = up(scene.camera.position - place).normalize();
        let expected = radiance(&SKIN, lamp(place), eye);
        worst = worst.max((f64::from(pixel[0]) / expected - 1.0).abs());
        ratio += f64::from(pixel[0]) / expected / picture.pixels.len() as f64;
    }
    (worst, ratio)
}

const SUN: &str = "{ type = 'directional', direction = [-1, 0.5, 0.2], irradiance = 2 }";

#[test]
fn even_layers_under_the_sun_are_exact_with_one_step() {
    let toward = DVec3::new(-1.0, -0.2, 0.5).normalize();
    for samples in [1, 2, 10] {
        let (worst, _) = error(&mut flat(SUN, samples, ""), |_| Lamp::Directional(toward, 2.0));
        // The ray ends where light is attenuated to 1e-4; normals and positions are rounded to f32.
        assert!(worst < 2e-4, "{samples}: {worst}");
    }
}

#[test]
fn the_left_rule_is_too_bright_and_the_exact_one_converges_faster() {
    let lamp = |p: DVec3| Lamp::Point(DVec3::new(2.0, -1.0, 3.0) - DVec3::new(p.x, -p.z, p.y), 30.0);
    let light = "{ type = 'point', position = [2, 3, 1], intensity = 30 }";
    let ours = |samples: u32| error(&mut flat(light, samples, ""), lamp).0;
    let theirs = |samples: u32| error(&mut flat(light, samples, ", integration = 'paper'"), lamp);
    let (ten, hundred) = (theirs(10), theirs(100));
    assert!(ten.1 > 1.1 && hundred.1 > 1.01 && hundred.1 < ten.1, "{ten:?} {hundred:?}");
    assert!(ours(10) < hundred.0 / 3.0, "{} {}", ours(10), hundred.0);
    // Second order, until the truncation of the ray dominates.
    assert!(ours(40) < ours(5) / 8.0, "{} {}", ours(5), ours(40));
    assert!(ours(100) < 3e-4, "{}", ours(100));
}
