//! Layers whose thickness varies along a plane, and reflection per channel, against sums over the same model that use
//! none of its code.

use std::f64::consts::PI;

use glam::DVec3;
use milkglass::internals::layout::Hit;
use milkglass::internals::pipeline::plan::{Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::{DepthMap, Scene, Wrap};

use super::{scene, session};

/// Side of the square, mm.
const SIDE: f64 = 20.0;
const TOWARD: DVec3 = DVec3::new(-0.8, 0.5, 0.33);
const IRRADIANCE: f64 = 3.0;
const SCATTERING: [f64; 2] = [2.0, 0.9];
const EXTINCTION: [f64; 2] = [2.6, 1.1];
const PHASE: [f64; 2] = [0.25, -0.3];
/// Depth of the lower end of the second layer.
const BOTTOM: f64 = 1.4;

/// Depth of the first interface at x: a ramp.
fn ramp(x: f64) -> f64 {
    0.6 + 0.12 * x
}

/// A square that faces +y, with two layers, under the sun.
fn square(more: &[&str]) -> Scene {
    let layer = |k: usize| {
        let [s, t, g] = [SCATTERING[k], EXTINCTION[k], PHASE[k]];
        format!("{{ sigma_s = {s}, sigma_t = {t}, g = {g}, thickness = 0.7 }}")
    };
    let sets = [
        "camera={ position = [12.0, 16.0, 7.0], target = [0.0, 0.0, 0.0], size = [13, 9], fov = 6 }".to_string(),
        format!(
            "light=[{{ type = 'directional', direction = [{}, {}, {}], irradiance = {IRRADIANCE} }}]",
            TOWARD.x, TOWARD.y, TOWARD.z
        ),
        "object.0.shape=plane".into(),
        format!("object.0.size={SIDE}"),
        "object.0.rotation=[0, 0, 0]".into(),
        format!("object.0.material={{ layers = {{ samples = 400, layer = [{}, {}] }} }}", layer(0), layer(1)),
    ];
    let sets: Vec<&str> = sets.iter().map(String::as_str).chain(more.iter().copied()).collect();
    let mut scene = scene("slab-layers", &sets);
    let object = &mut scene.objects[0];
    let u = |v: u32| object.mesh.positions[v as usize].x / SIDE + 0.5;
    object.mesh.uvs = Some(object.mesh.triangles.iter().map(|corners| corners.map(|v| [u(v), 0.5])).collect());
    scene
}

/// For each pixel the place on the square, the unit direction to the eye, and its value.
fn seen(session: &mut Session) -> Vec<(DVec3, DVec3, [f64; 3])> {
    let picture = session.picture().unwrap();
    let data = &session.state().data;
    let one = |(hit, value): (&Hit, &[f32; 3])| {
        let corners =
            data.triangles[hit.face as usize].map(|v| DVec3::from_array(data.positions[v as usize].map(f64::from)));
        let [u, v] = [hit.u, hit.v].map(f64::from);
        let place = session.units().outside(corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v);
        let eye = (session.scene().camera.position - place).normalize();
        (place, eye, value.map(f64::from))
    };
    data.hits.iter().zip(&picture.pixels).map(one).collect()
}

fn taken(scene: &Scene) -> Session {
    session(scene, Options { transport: ShadingMethod::None, ..Options::default() })
}

/// Equations 5 and 9 to 12 on a plane: the light's leg from M at depth d to K is d / mu long, and the part of it in the
/// first layer is the mean of that layer's depths at M and at K, at most d.
fn marched(place: DVec3, eye: DVec3) -> f64 {
    let toward = TOWARD.normalize();
    let cosine = toward.dot(eye);
    const STEPS: u32 = 20_000;
    let step = BOTTOM / eye.y / f64::from(STEPS);
    let (mut sum, mut above) = (0.0, 0.0);
    for i in 0..STEPS {
        let t = (f64::from(i) + 0.5) * step;
        let m = place - eye * t;
        let (depth, layer) = (-m.y, usize::from(-m.y >= ramp(m.x)));
        let first = f64::min(0.5 * ramp(m.x) + 0.5 * ramp(m.x + toward.x * depth / toward.y), depth);
        let leg = (EXTINCTION[0] * first + EXTINCTION[1] * (depth - first)) / toward.y;
        let k = PHASE[layer];
        let phase = (1.0 - k * k) / (4.0 * PI * (1.0 + k * cosine).powi(2));
        sum += SCATTERING[layer] * phase * IRRADIANCE * (-above - 0.5 * EXTINCTION[layer] * step - leg).exp() * step;
        above += EXTINCTION[layer] * step;
    }
    sum
}

#[test]
fn the_mean_of_both_ends_depths_dims_the_light() {
    let mut scene = square(&[]);
    // Between texels depths are linear, so a ramp needs only enough texels to reach the edges.
    const TEXELS: u32 = 64;
    let depth = |k: u32| ramp(SIDE * ((f64::from(k) + 0.5) / f64::from(TEXELS) - 0.5)).max(0.0);
    let depths: Vec<f64> = (0..TEXELS).flat_map(|k| [depth(k).min(BOTTOM), BOTTOM]).collect();
    scene.objects[0].material.layers.as_mut().unwrap().map =
        DepthMap::new([TEXELS, 1], 2, &depths, Wrap::Clamp).unwrap();
    let pixels = seen(&mut taken(&scene));
    assert_eq!(pixels.len(), 13 * 9);
    for (place, eye, value) in pixels {
        let expected = marched(place, eye);
        assert!(value.iter().all(|value| (value / expected - 1.0).abs() < 1e-3), "{value:?}, not {expected}");
    }
}

#[test]
fn each_channel_is_reflected_by_its_own_index() {
    let eta = [1.2, 1.6, 2.4];
    // Fresnel's formula for unpolarised light.
    let passes = |eta: f64, cosine: f64| {
        let inner = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).sqrt();
        let square = |a: f64, b: f64| ((a - b) / (a + b)).powi(2);
        1.0 - 0.5 * (square(cosine, eta * inner) + square(eta * cosine, inner))
    };
    for rule in ["exact", "paper"] {
        let integration = format!("object.0.material.layers.integration={rule}");
        let with = ["object.0.material.eta=[1.2, 1.6, 2.4]", "object.0.material.layers.fresnel=true", &integration];
        let [bare, reflected] = [&with[2..], &with[..]].map(|more| seen(&mut taken(&square(more))));
        assert_eq!(bare.len(), 13 * 9);
        for ((_, eye, bare), (_, _, found)) in bare.iter().zip(&reflected) {
            for c in 0..3 {
                let expected = bare[c] * passes(eta[c], TOWARD.normalize().y) * passes(eta[c], eye.y);
                assert!((found[c] / expected - 1.0).abs() < 1e-4, "{rule} {c}: {} for {expected}", found[c]);
            }
        }
    }
}
