//! The reference of the march: light that comes through thin parts, against closed forms for plates.

use std::f64::consts::PI;

use glam::DVec3;
use milkglass::internals::layers::relief::{Kept, full};
use milkglass::internals::layers::slab::{Lamp, SlabLayer, radiance};
use milkglass::internals::pipeline::plan::{Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Mesh;

use super::{scene, session};

const SCATTERING: f64 = 0.8;
const EXTINCTION: f64 = 1.3;

/// Boxes of 60 x 60 mm between these heights along z, as one mesh.
fn plates(heights: &[[f64; 2]]) -> Mesh {
    const QUADS: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corner = |k: u32, z: [f64; 2]| {
        let side = |bit: u32| if k >> bit & 1 == 1 { 30.0 } else { -30.0 };
        DVec3::new(side(0), side(1), z[(k >> 2) as usize])
    };
    let positions: Vec<DVec3> = heights.iter().flat_map(|&z| (0..8).map(move |k| corner(k, z))).collect();
    let quads = (0..heights.len() as u32).flat_map(|part| QUADS.map(|quad| quad.map(|v| v + 8 * part)));
    let triangles: Vec<[u32; 3]> = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, input_face: (0..triangles.len() as u32).collect(), triangles, ..Mesh::default() }
}

/// A session of these plates of one layer, seen from above their middle.
fn seen(heights: &[[f64; 2]], light: &str, more: &[&str]) -> Session {
    let layers = format!(
        "object.0.material={{ eta = [1.3, 1.5, 1.8], layers = {{ layer = [{{ sigma_s = {SCATTERING}, sigma_t = \
         {EXTINCTION}, g = 0.3, thickness = 50 }}] }} }}"
    );
    let camera = "camera={ position = [9.0, 5.0, 30.0], target = [0.0, 0.0, 0.0], size = [7, 5], fov = 8 }";
    let light = format!("light=[{light}]");
    let mut scene = scene("slab-layers", &[&[camera, &light, &layers], more].concat());
    let object = &mut scene.objects[0];
    (object.mesh, object.rotation, object.position) = (plates(heights), Default::default(), Default::default());
    session(&scene, Options { transport: ShadingMethod::None, ..Options::default() })
}

/// The unit direction to the eye from what each pixel shows, with the pixel's reference.
fn pixels(session: &Session, kept: Kept) -> Vec<(DVec3, [f64; 3])> {
    let (data, units) = (&session.state().data, session.units());
    let one = |(pixel, hit): (usize, &milkglass::internals::layout::Hit)| {
        let corners = data.triangles[hit.face as usize].map(|v| data.in_scene()[v as usize]);
        let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let place = (0..3).map(|k| DVec3::from_array(corners[k].map(f64::from)) * f64::from(weight[k])).sum();
        let eye = (session.scene().camera.position - units.outside(place)).normalize();
        (eye, full(session.state(), pixel, kept, 500, 50).unwrap())
    };
    data.hits.iter().enumerate().map(one).collect()
}

fn sun(toward: DVec3, more: &str) -> String {
    format!("{{ type = 'directional', direction = [{}, {}, {}], irradiance = 2 {more} }}", toward.x, toward.y, toward.z)
}

/// Light from below through a plate of this thickness: sigma_s p E / mu_o times the integral over the depth z of
/// e^(-sigma_t (z / mu_o + (thickness - z) / mu_i)).
fn through(thickness: f64, toward: DVec3, eye: DVec3) -> f64 {
    let (mu, rate) = (-toward.z, EXTINCTION * (1.0 / eye.z + 1.0 / toward.z));
    let phase = (1.0 - 0.09) / (4.0 * PI * (1.0 + 0.3 * toward.dot(eye)).powi(2));
    let depth = (-EXTINCTION * thickness / mu).exp() * -(-rate * thickness).exp_m1() / rate;
    SCATTERING * phase * 2.0 * depth / eye.z
}

fn all_near(found: &[(DVec3, [f64; 3])], expected: impl Fn(DVec3, usize) -> f64) {
    assert_eq!(found.len(), 35);
    for (eye, pixel) in found {
        for (c, value) in pixel.iter().enumerate() {
            let expected = expected(*eye, c);
            assert!((value - expected).abs() <= 1e-3 * expected, "{c}: {value}, not {expected}");
        }
    }
}

const BEHIND: DVec3 = DVec3::new(0.3, -0.2, -0.933);

#[test]
fn light_from_behind_comes_through_a_thin_plate() {
    let toward = BEHIND.normalize();
    let thin = seen(&[[-0.9, 0.0]], &sun(toward, ""), &[]);
    all_near(&pixels(&thin, Kept::default()), |eye, _| through(0.9, toward, eye));
    // A lamp so far away that its light is parallel.
    let far = 1e5 * toward;
    let lamp = format!("{{ type = 'point', position = [{}, {}, {}], intensity = 2e10 }}", far.x, far.y, far.z);
    all_near(&pixels(&seen(&[[-0.9, 0.0]], &lamp, &[]), Kept::default()), |eye, _| through(0.9, toward, eye));
    // The march counts lights by the visible triangle's shadows: none arrives.
    for kept in [Kept::ALL, Kept { triangle_shadow: true, ..Kept::default() }] {
        all_near(&pixels(&thin, kept), |_, _| 0.0);
    }
    // From the front, where the plate is deep enough for the part of the ray that matters, there is the closed form.
    let front = DVec3::new(-0.4, 0.3, 0.8).normalize();
    let layer = SlabLayer { sigma_s: SCATTERING, sigma_t: EXTINCTION, g: 0.3, thickness: 0.9 };
    let lit = seen(&[[-0.9, 0.0]], &sun(front, ""), &[]);
    all_near(&pixels(&lit, Kept::default()), |eye, _| radiance(&[layer], Lamp::Directional(front, 2.0), eye));
}

#[test]
fn what_lies_behind_attenuates_or_blocks() {
    let toward = BEHIND.normalize();
    // Another part of the same object, beyond a gap: light is attenuated in both, and not between them.
    let two = [[-0.9, 0.0], [-3.0, -2.3]];
    let again = (EXTINCTION * 0.7 / toward.z).exp();
    let both = pixels(&seen(&two, &sun(toward, ""), &[]), Kept::default());
    all_near(&both, |eye, _| again * through(0.9, toward, eye));
    // Overlapping parts are one part.
    let joined = pixels(
        &seen(&[[-0.9, 0.0], [-1.6, -0.6]], &sun(toward, ""), &[]),
        Kept { mean_depths: false, ..Kept::default() },
    );
    all_near(&joined, |eye, _| through(1.6, toward, eye));
    // Without shadows only the first part counts, and nothing blocks.
    let board = "object.1={ shape = 'sphere', size = 40, position = [0, 0, -30], material = { opaque = true } }";
    let free = pixels(&seen(&two, &sun(toward, ", shadows = false"), &[board]), Kept::default());
    all_near(&free, |eye, _| through(0.9, toward, eye));
    // Another object blocks.
    all_near(&pixels(&seen(&two[..1], &sun(toward, ""), &[board]), Kept::default()), |_, _| 0.0);
    let lamp = "{ type = 'point', position = [0, 0, -5], intensity = 9 }";
    let before = pixels(&seen(&two[..1], lamp, &[board]), Kept::default());
    assert!(before.iter().all(|(_, pixel)| pixel[0] > 0.0), "the board lies behind the lamp");
}

#[test]
fn parts_end_at_interfaces_however_few_there_are() {
    // A thin bright layer over a dense one, which ends within a step.
    let layers = "object.0.material.layers.layer=[{ sigma_s = 0.8, sigma_t = 1.3, g = 0.3, thickness = 0.37 }, \
                  { sigma_s = 0.05, sigma_t = 4, thickness = 2.5 }]";
    let front = DVec3::new(-0.4, 0.3, 0.8).normalize();
    let lit = seen(&[[-3.0, 0.0]], &sun(front, ""), &[layers]);
    let slab = [
        SlabLayer { sigma_s: 0.8, sigma_t: 1.3, g: 0.3, thickness: 0.37 },
        SlabLayer { sigma_s: 0.05, sigma_t: 4.0, g: 0.0, thickness: 2.5 },
    ];
    for (pixel, (eye, _)) in pixels(&lit, Kept::default()).iter().enumerate() {
        let expected = radiance(&slab, Lamp::Directional(front, 2.0), *eye);
        let error =
            |steps: u32| (full(lit.state(), pixel, Kept::default(), steps, 50).unwrap()[0] / expected - 1.0).abs();
        // Second order in the step; parts that end elsewhere make it first order, 0.02 with 32 steps.
        let [coarse, fine, finest] = [16, 32, 64].map(error);
        assert!(coarse < 4e-3 && fine < 1e-3 && finest < 3e-4, "{pixel}: {coarse} {fine} {finest}");
    }
}

#[test]
fn reflection_at_the_boundary_is_in_the_reference() {
    let toward = BEHIND.normalize();
    let fresnel = "object.0.material.layers.fresnel=true";
    // Fresnel's formula for unpolarised light.
    let passes = |eta: f64, cosine: f64| {
        let inner = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).sqrt();
        let square = |a: f64, b: f64| ((a - b) / (a + b)).powi(2);
        1.0 - 0.5 * (square(cosine, eta * inner) + square(eta * cosine, inner))
    };
    let found = pixels(&seen(&[[-0.9, 0.0]], &sun(toward, ""), &[fresnel]), Kept::default());
    all_near(&found, |eye, c| {
        let eta = [1.3, 1.5, 1.8][c];
        through(0.9, toward, eye) * passes(eta, -toward.z) * passes(eta, eye.z)
    });
}
