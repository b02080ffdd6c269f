//! Light scattered once in the medium, against closed forms and a random walk.

use glam::DVec3;
use milkglass::internals::layers::beneath::phase;
use milkglass::internals::layers::single_scattering::half_space;
use milkglass::internals::layout::{LIGHT_DIRECTIONAL, Light};
use milkglass::internals::lighting::fresnel::transmittance;
use milkglass::internals::pipeline::plan::{Goal, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use super::{scene, session};

/// Options of pictures that hold only light scattered once.
fn alone() -> Options {
    Options { transport: ShadingMethod::None, ..Options::default() }
}

/// Each pixel of a session's picture with the point that it shows and the unit direction to the eye.
fn shown(session: &mut Session) -> Vec<(DVec3, DVec3, DVec3)> {
    let picture = session.picture().unwrap();
    let (state, units, eye) = (session.state(), session.units(), session.scene().camera.position);
    let mut found = Vec::new();
    for (pixel, hit) in picture.pixels.iter().zip(&state.data.hits).filter(|(_, hit)| hit.face < u32::MAX - 1) {
        let corners = state.data.triangles[hit.face as usize].map(|v| state.data.in_scene()[v as usize]);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let place: DVec3 =
            corners.iter().zip(weights).map(|(p, w)| DVec3::from_array(p.map(f64::from)) * f64::from(w)).sum();
        let place = units.outside(place);
        found.push((DVec3::from_array(pixel.map(f64::from)), place, (eye - place).normalize()));
    }
    found
}

/// The direction inside of a direction outside, both away from the surface.
fn refracted(eta: f64, toward: DVec3, normal: DVec3) -> DVec3 {
    let across = (toward - toward.dot(normal) * normal) / eta;
    across + (1.0 - across.length_squared()).sqrt() * normal
}

#[test]
fn a_half_space_is_its_closed_form() {
    let (sigma_s, sigma_a) = ([4.0, 2.0, 9.0], [0.5, 3.0, 0.0]);
    let mut darkest = f64::INFINITY;
    for (eta, g, sun) in [
        ([1.0, 1.3, 1.5], [0.0, 0.4, -0.6], [-1.0, 0.5, 0.2]),
        ([1.5; 3], [0.8, 0.0, 0.3], [0.1, 1.0, 0.0]),
        ([1.4, 1.4, 0.9], [0.2; 3], [0.8, 2.0, -0.5]),
        ([2.0; 3], [0.9, -0.9, 0.5], [-3.0, 0.3, 0.0]),
    ] {
        let sets = [
            "camera={ position = [10.0, 8.0, 14.0], target = [0.0, 0.0, 0.0], size = [17, 13], fov = 12 }".to_string(),
            format!("light=[{{ type = 'directional', direction = {sun:?}, irradiance = [2, 3, 1] }}]"),
            "object.0.shape=plane".to_string(),
            "object.0.size=400".to_string(),
            "object.0.detail=8".to_string(),
            format!(
                "object.0.material={{ sigma_s_prime = {:?}, sigma_a = {sigma_a:?}, eta = {eta:?}, g = {g:?}, \
                 single_scattering = true }}",
                [0, 1, 2].map(|c| sigma_s[c] * (1.0 - g[c]))
            ),
        ];
        let mut session = session(&scene("sphere", &sets.each_ref().map(String::as_str)), alone());
        let (up, toward) = (DVec3::Y, DVec3::from_array(sun).normalize());
        let pixels = shown(&mut session);
        assert_eq!(pixels.len(), 17 * 13);
        for (found, _, eye) in pixels {
            for c in 0..3 {
                let enters = transmittance(eta[c], toward.y) * transmittance(eta[c], eye.y) > 0.0;
                let turn = if enters { refracted(eta[c], toward, up).dot(refracted(eta[c], eye, up)) } else { 0.0 };
                let albedo = sigma_s[c] / (sigma_s[c] + sigma_a[c]);
                let expected = match enters {
                    true => half_space(albedo, eta[c], phase(true, g[c], turn), toward.y, eye.y),
                    false => 0.0,
                };
                let expected = [2.0, 3.0, 1.0][c] * expected;
                // Near the critical angle transmittance grows like a root: a rounding of 1e-7 counts a thousandfold.
                let least = if eta[c] < 1.0 { 1e-3 } else { 3e-5 };
                let close = (found[c] - expected).abs() <= least * expected;
                assert!(close, "{eta:?} {g:?} {c}: {}, {expected}", found[c]);
                darkest = darkest.min(expected);
            }
        }
    }
    // Below the critical angle nothing comes out.
    assert_eq!(darkest, 0.0);
}

#[test]
fn a_ball_without_refraction_is_its_integral() {
    // From x down the view ray, and from there straight to the light: through the ball both times.
    let (radius, sigma_s, sigma_t, g) = (5.0, [0.2, 0.5, 0.05], [0.3, 0.5, 0.2], [0.5, -0.3, 0.0]);
    let lights = [
        "{ type = 'directional', direction = [0.4, 0.3, 1], irradiance = 2 }",
        "{ type = 'directional', direction = [-0.2, 0.3, -1], irradiance = 2 }",
        "{ type = 'point', position = [3, 2, 9], intensity = 100 }",
        "{ type = 'point', position = [-4, 1, -7], intensity = 100 }",
    ];
    for light in lights {
        let sets = [
            "camera={ position = [0, 0, 40], target = [0, 0, 0], size = [25, 25], fov = 15 }".to_string(),
            format!("light=[{light}]"),
            "object.0.detail=6".to_string(),
            format!(
                "object.0.material={{ sigma_s_prime = {:?}, sigma_a = {:?}, eta = 1, g = {g:?}, single_scattering = true }}",
                [0, 1, 2].map(|c| sigma_s[c] * (1.0 - g[c])),
                [0, 1, 2].map(|c: usize| sigma_t[c] - sigma_s[c])
            ),
        ];
        let mut session = session(&scene("sphere", &sets.each_ref().map(String::as_str)), alone());
        let (units, lamp) = (*session.units(), session.state().data.lights[0]);
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let arrives = |lamp: &Light, at: DVec3| match lamp.kind {
            LIGHT_DIRECTIONAL => (wide(lamp.place), 2.0),
            _ => {
                let apart = units.outside(wide(lamp.place)) - at;
                (apart.normalize(), 100.0 / apart.length_squared())
            }
        };
        let leaves = |at: DVec3, way: DVec3| {
            let along = at.dot(way);
            -along + (along * along + radius * radius - at.length_squared()).max(0.0).sqrt()
        };
        let pixels = shown(&mut session);
        assert!(pixels.len() > 200);
        let (mut errors, mut sizes) = (DVec3::ZERO, DVec3::ZERO);
        for (found, place, eye) in pixels {
            let place = place.normalize() * radius;
            let (chord, steps) = (leaves(place, -eye), 400);
            let at = |k: u32| {
                let s = chord * (f64::from(k) + 0.5) / f64::from(steps);
                let place = place - s * eye;
                let (toward, light) = arrives(&lamp, place);
                let radiance = |c: usize| {
                    let dimmed = (-sigma_t[c] * (s + leaves(place, toward))).exp();
                    sigma_s[c] * phase(true, g[c], toward.dot(eye)) * light * dimmed
                };
                DVec3::new(radiance(0), radiance(1), radiance(2)) * chord / f64::from(steps)
            };
            let expected: DVec3 = (0..steps).map(at).sum();
            errors += (found - expected) * (found - expected);
            sizes += expected * expected;
        }
        // The error left by the steps, and by the triangles of the ball.
        let error = (errors / sizes).max_element().sqrt();
        println!("{light}: {error:.1e}");
        assert!(error < 0.02, "{light}: {error}");
    }
}

/// Abscissas and weights of Gauss and Legendre's rule of 6 points on 0 to 1.
const GAUSS: [[f64; 2]; 6] = [
    [0.033_765_242_898_423_97, 0.085_662_246_189_585_17],
    [0.169_395_306_766_867_65, 0.180_380_786_524_069_3],
    [0.380_690_406_958_401_5, 0.233_956_967_286_345_5],
    [0.619_309_593_041_598_5, 0.233_956_967_286_345_5],
    [0.830_604_693_233_132_4, 0.180_380_786_524_069_3],
    [0.966_234_757_101_576, 0.085_662_246_189_585_17],
];

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_flat_face_shows_the_order_that_a_walk_tallies() {
    // A slab of 200 free paths, lit on one side, or aslant on two sides alike, where the azimuth does not matter.
    let walks = 120_000;
    for (sun, cosine, eta, g) in [("[0, 0, 1]", 1.0, 1.4, 0.6), ("[1, 0, 1]", 0.5f64.sqrt(), 1.3, 0.0)] {
        let make = |once: bool| -> Scene {
            let sets = [
                format!("light=[{{ type = 'directional', direction = {sun}, irradiance = 1, shadows = false }}]"),
                format!(
                    "object.0.material={{ sigma_s_prime = {:?}, sigma_a = [5, 15, 35], eta = {eta}, g = {g}, \
                     single_scattering = {once} }}",
                    [45.0, 35.0, 15.0].map(|s| s * (1.0 - g))
                ),
                format!("transport.walks={walks}"),
                "camera.size=[1, 1]".to_string(),
                "object.0.shape=slab".to_string(),
                "object.0.detail=8".to_string(),
                "object.0.size=20".to_string(),
            ];
            scene("sphere", &sets.each_ref().map(String::as_str))
        };
        let walk = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
        let walked = session(&make(false), walk);
        let tallied = [0, 1, 2].map(|c| {
            walked.state().data.exits.iter().map(|exit| exit.once(c) as f64).sum::<f64>()
                / f64::from(walks)
                / f64::exp2(30.0)
        });

        // The radiance of the lit face, over the hemisphere, as a share of what enters.
        let mut shown_once = DVec3::ZERO;
        let (mut slab, middle) = (make(true), DVec3::new(0.3, 0.4, 2.0));
        for [mu, weight] in GAUSS {
            slab.camera.position = middle + 100.0 * DVec3::new(0.0, (1.0 - mu * mu).sqrt(), mu);
            (slab.camera.target, slab.camera.fov) = (middle, 0.1);
            let (radiance, place, eye) = shown(&mut session(&slab, alone()))[0];
            assert!((place - middle).length() < 0.1 && (eye.z - mu).abs() < 1e-3);
            shown_once += radiance * weight * mu * std::f64::consts::TAU;
        }
        let entered = cosine * transmittance(eta, cosine);
        for c in 0..3 {
            let found = shown_once[c] / entered;
            let error = (tallied[c] * (1.0 - tallied[c]) / f64::from(walks)).sqrt();
            println!("{sun} {c}: {found:.5} shown, {:.5} +- {error:.5} tallied", tallied[c]);
            assert!((found - tallied[c]).abs() < 3.5 * error + 5e-4, "{sun} {c}: {found}, {}", tallied[c]);
        }
    }
}
