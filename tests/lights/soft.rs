//! Soft light on opaque surfaces, pixel by pixel: it converges with the samples, each takes its share of a light's
//! points, and no two neighbours take the same.

use glam::DVec3;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;

use super::scene;

/// A ball over a sheet, seen from above, by a picture of 24 x 24 with so many samples; a panel of `panel` x `panel`
/// points and a sky of `sky` rays.
fn session(samples: u32, panel: u32, sky: u32) -> Session {
    let sets = [
        &format!(
            "camera={{ position = [0, 60, 1], target = [0, 0, 0], fov = 40, size = [24, 24], samples = {samples} }}"
        ),
        "object.0.detail=3",
        "object.0.size=12",
        "object.0.material={ opaque = true, albedo = [0.5, 0.5, 0.5] }",
        "object.1={ shape = 'plane', size = 90, position = [0, -9, 0], material = { opaque = true, albedo = 0.8 } }",
        &format!(
            "light.0={{ type = 'area', position = [6, 25, 0], edge_u = [12, 0, 0], edge_v = [0, 0, 12], radiance = 4, \
             samples = {panel} }}"
        ),
        &format!("light.1={{ type = 'environment', radiance = [0.4, 0.5, 0.7], occlusion = {sky} }}"),
    ];
    let mut session = Session::new(&scene("sphere", &sets), None, Options::default()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn picture(samples: u32, panel: u32, sky: u32) -> Vec<DVec3> {
    let pixels = session(samples, panel, sky).render().unwrap().pixels;
    pixels.into_iter().map(|pixel| DVec3::from_array(pixel.map(f64::from))).collect()
}

/// Root mean square of the difference, and the mean difference, as shares of the mean.
fn apart(found: &[DVec3], truth: &[DVec3]) -> [f64; 2] {
    let mean = truth.iter().map(|pixel| pixel.element_sum()).sum::<f64>() / truth.len() as f64;
    let each = || found.iter().zip(truth).map(|(a, b)| (*a - *b).element_sum() / mean);
    let count = truth.len() as f64;
    [(each().map(|x| x * x).sum::<f64>() / count).sqrt(), each().sum::<f64>() / count]
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn more_samples_come_nearer_whatever_the_lights_ask_for() {
    // The same places in the pixels: only the light differs.
    let truth = picture(64, 64, 4096);
    let [few, bias] = apart(&picture(64, 4, 64), &truth);
    assert!(few < 0.01 && bias.abs() < 0.001, "64 samples: {few}, {bias}");
    // One sample at the centres of the pixels against many there: grain, but no bias.
    let centre = picture(1, 64, 4096);
    let [one, bias] = apart(&picture(1, 4, 64), &centre);
    assert!(one > few && one < 0.06 && bias.abs() < 0.006, "1 sample: {one}, {bias}");
}

#[test]
fn a_sample_takes_its_share_of_points_and_rays() {
    let records = |samples, panel, sky| session(samples, panel, sky).state().data.pixel_lights.len();
    assert_eq!(records(1, 4, 64), 16 + 64);
    assert_eq!(records(16, 4, 64), 1 + 4);
    assert_eq!(records(8, 4, 64), 2 + 8);
    assert_eq!(records(64, 1, 1), 1 + 4, "what is hidden of the sky takes a few rays");
    assert_eq!(records(16, 4, 0), 1, "none hide the sky where none is asked for");
}

#[test]
fn neighbours_see_other_points_of_a_light() {
    // On bare ground in a penumbra, neighbours that saw the same points would differ smoothly.
    let grain = |samples| {
        let pixels = picture(samples, 2, 8);
        let second = |at: usize| (pixels[at - 1] - 2.0 * pixels[at] + pixels[at + 1]).element_sum().abs();
        (0..24).flat_map(|row| (1..23).map(move |column| row * 24 + column)).map(second).sum::<f64>()
    };
    let [rough, fine] = [grain(1), grain(64)];
    assert!(rough > 3.0 * fine, "{rough}, {fine}");
}

#[test]
fn a_sheet_under_a_panel_gets_its_integral() {
    // One bare sheet, seen from straight above, and a panel at height 20 over its middle: E = L int cos cos' / d^2 dA.
    let sets = [
        "camera={ position = [0, 60, 0], target = [0, 0, 0], up = [0, 0, -1], fov = 60, size = [12, 12], samples = 64 }",
        "object.0={ shape = 'plane', size = 300, material = { opaque = true, albedo = 0.6, eta = 1 } }",
        "light.0={ type = 'area', position = [3, 20, 0], edge_u = [14, 0, 0], edge_v = [0, 0, 10], radiance = 2, samples = 3 }",
    ];
    let mut session = Session::new(&scene("sphere", &sets), None, Options::default()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let found = session.render().unwrap().pixels;
    let panel = |at: DVec3| {
        let part = |k: usize, side: f64| side * ((k as f64 + 0.5) / 60.0 - 0.5);
        let each = (0..3600).map(|k| DVec3::new(3.0 + part(k % 60, 14.0), 20.0, part(k / 60, 10.0)) - at);
        each.map(|way| 2.0 * way.y * way.y / way.length_squared().powi(2) * 140.0 / 3600.0).sum::<f64>()
    };
    let mut off = Vec::new();
    for (pixel, found) in found.into_iter().enumerate() {
        // The mean over the pixel's square of the sheet.
        let side = 2.0 * 60.0 * 30f64.to_radians().tan() / 12.0;
        let corner = |k: usize| (k as f64 - 6.0) * side;
        let inner = |k: usize| side * (k as f64 + 0.5) / 8.0;
        let place = |k: usize| DVec3::new(corner(pixel % 12) + inner(k % 8), 0.0, corner(pixel / 12) + inner(k / 8));
        let mean = (0..64).map(|k| panel(place(k))).sum::<f64>() / 64.0;
        let expected = 0.6 / std::f64::consts::PI * mean;
        off.push(f64::from(found[1]) / expected - 1.0);
    }
    let mean = off.iter().sum::<f64>() / 144.0;
    let rms = (off.iter().map(|x| x * x).sum::<f64>() / 144.0).sqrt();
    assert!(mean.abs() < 0.002 && rms < 0.02, "on average {mean}, root mean square {rms}");
}
