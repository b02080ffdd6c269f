//! Whether a mesh shows its translucency at its size, and what was assumed about it, in words.

use super::super::{Object, Scene};
use super::lights::Backdrop;
use super::pose::Up;
use glam::DVec3;

/// Share of light that passes: below it an object looks opaque.
const OPAQUE: f64 = 0.02;
/// The share at the size that is proposed.
const GOOD: f64 = 0.12;

/// The typical thickness of a closed mesh, in scene units: 2 V / A, which is that of a sheet.
fn thickness(object: &Object) -> f64 {
    let mesh = &object.mesh;
    let corners = (0..).map_while(|triangle| mesh.corners(triangle));
    let middle = mesh.positions.iter().sum::<DVec3>() / mesh.positions.len().max(1) as f64;
    let (volume, area) = corners.fold((0.0, 0.0), |(volume, area), corners| {
        let [a, b, c] = corners.map(|corner| corner - middle);
        (volume + a.dot(b.cross(c)) / 6.0, area + (b - a).cross(c - a).length() / 2.0)
    });
    2.0 * volume.abs() / f64::max(area, f64::MIN_POSITIVE)
}

/// The share of diffuse light that passes a sheet of this thickness: two-stream diffusion, without the boundary; that
/// of the channel with most. And the sheet's thickness in mean free paths in the densest channel.
fn passes(object: &Object, thickness: f64) -> (f64, f64) {
    let of_channel = |c: usize| {
        let (scatter, absorb) = (object.material.sigma_s_prime[c], object.material.sigma_a[c]);
        let free = thickness * (scatter + absorb);
        let x = thickness * (3.0 * absorb * (absorb + scatter)).sqrt();
        let absorbed = if x > 1e-6 { x / x.sinh() } else { 1.0 };
        (absorbed / (1.0 + 0.75 * free), free)
    };
    (0..3).map(of_channel).fold((0.0, 0.0), |all, channel| (f64::max(all.0, channel.0), f64::max(all.1, channel.1)))
}

/// A size, rounded to two digits.
fn rounded(size: f64) -> f64 {
    let step = 10f64.powf(size.log10().floor() - 1.0);
    format!("{:.6e}", (size / step).round() * step).parse().unwrap_or(size)
}

/// What was assumed, and a size that shows translucency better if this one does not. `sheets` are the numbers of the
/// objects that are sheets.
pub(super) fn told(
    scene: &Scene,
    sheets: &[usize],
    name: &str,
    up: Up,
    guessed: bool,
    backdrop: &Backdrop,
) -> Vec<String> {
    let (low, high) = scene.bounds();
    let extent = (high - low).max_element() * scene.unit_mm;
    let materials: Vec<&str> = scene.objects.iter().map(|object| object.material.name.as_str()).collect();
    let mut material = materials.first().map_or_else(String::new, |name| name.to_lowercase());
    if materials.iter().any(|name| Some(name) != materials.first()) {
        material = format!("{} materials", materials.len());
    }
    let axis = if up == Up::Z { "z" } else { "y" };
    let sure = if guessed { " is up (a guess: --up)" } else { " is up" };
    let mut lines = vec![format!(
        "{name}: {axis}{sure}, {} mm (--size-mm), {material} (--preset), {}",
        rounded(extent),
        backdrop.words()
    )];
    // A sheet has no thickness.
    let solid = |(number, object): &(usize, &Object)| object.material.opaque.is_none() && !sheets.contains(number);
    let Some((_, object)) = scene.objects.iter().enumerate().find(solid) else { return lines };
    let thick = thickness(object);
    if thick * scene.unit_mm < 1e-4 * extent {
        return lines;
    }
    let (share, free) = passes(object, thick);
    let fits = |fits: &dyn Fn(f64) -> bool| {
        // Bisect the logarithm of the factor on the size.
        let (mut small, mut large) = (-12.0f64, 12.0f64);
        for _ in 0..60 {
            let middle = (small + large) / 2.0;
            if fits(thick * middle.exp()) { large = middle } else { small = middle }
        }
        rounded(extent * large.exp())
    };
    if share < OPAQUE {
        let better = fits(&|thick| passes(object, thick).0 < GOOD);
        lines.push(format!(
            "{name}: looks opaque, {free:.0} mean free paths thick: --size-mm {better} shows more of the light in it"
        ));
    } else if free < 1.0 {
        let better = fits(&|thick| passes(object, thick).1 > 3.0);
        lines.push(format!(
            "{name}: thinner than a mean free path, {free:.2} of one: --size-mm {better} shows more of the light in it"
        ));
    }
    lines
}
