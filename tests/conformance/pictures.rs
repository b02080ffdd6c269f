//! The built-in scenes against small reference pictures, compared as an eye would: slightly blurred, in CIE Lab.
//!
//! After an intended change of look: `milkglass render NAME --size 240x240 --set camera.samples=1 -o
//! tests/pictures/NAME.png`; see also `MORE` and `LARGE`.

use std::path::Path;

use crate::devices;
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::{BUILTIN, Scene};
use rayon::prelude::*;

/// Unnoticeable colour differences: the mean, and the 99th percentile.
const MEAN: f64 = 0.5;
const WORST: f64 = 2.5;

/// Lab values of an 8-bit sRGB picture after a 3 x 3 mean.
fn lab(bytes: &[u8], width: usize, height: usize) -> Vec<[f64; 3]> {
    let linear = |byte: u8| {
        let x = f64::from(byte) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let at = |x: usize, y: usize, c: usize| linear(bytes[3 * (y * width + x) + c]);
    let curve = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
    let mut out = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let mut rgb = [0.0; 3];
            let mut count = 0.0;
            for v in y.saturating_sub(1)..(y + 2).min(height) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    count += 1.0;
                    rgb.iter_mut().enumerate().for_each(|(c, sum)| *sum += at(u, v, c));
                }
            }
            let [r, g, b] = rgb.map(|sum| sum / count);
            let xyz = [
                (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505,
                0.2126 * r + 0.7152 * g + 0.0722 * b,
                (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089,
            ];
            let [fx, fy, fz] = xyz.map(curve);
            out.push([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]);
        }
    }
    out
}

/// Mean and 99th percentile of the colour difference.
fn difference(a: &[u8], b: &[u8], width: usize, height: usize) -> (f64, f64) {
    let mut all: Vec<f64> = lab(a, width, height)
        .iter()
        .zip(lab(b, width, height))
        .map(|(p, q)| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt())
        .collect();
    all.sort_by(f64::total_cmp);
    (all.iter().sum::<f64>() / all.len() as f64, all[all.len() * 99 / 100])
}

fn reference(name: &str) -> (Vec<u8>, usize, usize) {
    let path = Path::new("tests/pictures").join(format!("{name}.png"));
    let picture = image::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).to_rgb8();
    let (width, height) = picture.dimensions();
    (picture.into_raw(), width as usize, height as usize)
}

/// Additional pictures: file name, scene, settings, shading method.
const MORE: [(&str, &str, &[&str], ShadingMethod); 1] =
    [("bust-cdrf", "bust", &["object.0.material.sigma_0=[1.5, 0.8, 0.4]", "light.0.occlusion=8"], ShadingMethod::Cdrf)];

/// Scenes that take the CPU long: the stored picture is the CPU's exact output, which devices have to match. Write it
/// with `--device cpu --set camera.samples=1`, and again after any change that alters a bit of it.
const LARGE: [&str; 4] = ["bump", "bust", "twist", "veins"];

fn render(name: &str, width: usize, height: usize, device: Option<&Device>) -> Vec<u8> {
    let more = MORE.iter().find(|(file, ..)| *file == name);
    let (scene, transport) = more.map_or((name, ShadingMethod::Hierarchy), |more| (more.1, more.3));
    let sets: Vec<String> = more.iter().flat_map(|more| more.2).map(|set| set.to_string()).collect();
    let camera = [format!("camera.size=[{width}, {height}]"), "camera.samples=1".into()];
    let scene = Scene::load_with(scene, &[&camera, &sets[..]].concat()).unwrap();
    let options = Options { transport, ..Options::default() };
    let mut session = Session::new(&scene, device, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session.picture().unwrap().bytes()
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_built_in_scenes_look_as_they_did() {
    let names: Vec<&str> = BUILTIN.iter().map(|(name, ..)| *name).chain(MORE.map(|(name, ..)| name)).collect();
    let on_cpu = |name: &str| {
        let (expected, width, height) = reference(name);
        if LARGE.contains(&name) {
            return expected;
        }
        let found = render(name, width, height, None);
        let (mean, worst) = difference(&expected, &found, width, height);
        assert!(mean < MEAN && worst < WORST, "{name} on the CPU: mean {mean}, 99th percentile {worst}");
        found
    };
    let all: Vec<(&str, Vec<u8>)> = names.into_par_iter().map(|name| (name, on_cpu(name))).collect();
    devices::on_devices_each(&all, |device, (name, on_cpu)| {
        // At most one step of 255 in any channel.
        let (_, width, height) = reference(name);
        let on_device = render(name, width, height, Some(device));
        let steps = on_cpu.iter().zip(&on_device).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(steps <= Some(1), "{name}: {} and CPU differ by {steps:?} of 255", device.name());
    });
}

#[test]
fn a_different_picture_is_noticed() {
    let (expected, width, height) = reference("sphere");
    let darker: Vec<u8> = expected.iter().map(|&x| (f64::from(x) * 0.95) as u8).collect();
    let (mean, worst) = difference(&expected, &darker, width, height);
    assert!(mean > MEAN || worst > WORST, "5 % darker went unseen: {mean}, {worst}");
    let mut shifted = expected.clone();
    shifted.rotate_right(3 * 4);
    let (mean, worst) = difference(&expected, &shifted, width, height);
    assert!(mean > MEAN || worst > WORST, "a shift by 4 pixels went unseen: {mean}, {worst}");
}
