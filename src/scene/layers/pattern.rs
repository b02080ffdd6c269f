//! Built-in depth maps.

use std::f64::consts::TAU;

/// The names of the maps.
pub(super) const NAMES: [&str; 3] = ["builtin:fish", "builtin:skin", "builtin:veins"];

/// Texels along a side.
const SIDE: u32 = 512;

/// Whether a map of this name is built in.
pub(super) fn is(name: &str) -> bool {
    NAMES.contains(&name)
}

/// The map of this name: channels as fractions of the scale, 0 at the surface. Skin and veins tile without seams.
pub(super) fn of(name: &str) -> Option<([u32; 2], Vec<[f32; 4]>)> {
    let depths: fn(f64, f64) -> [f64; 4] = match name {
        "builtin:fish" => fish,
        "builtin:skin" => skin,
        "builtin:veins" => veins,
        _ => return None,
    };
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE);
    let texel = |k: u32| depths(place(k % SIDE), place(k / SIDE)).map(|x| x.clamp(0.0, 1.0) as f32);
    Some(([SIDE, SIDE], (0..SIDE * SIDE).map(texel).collect()))
}

/// A sum of sine waves, about -1 to 1, periodic over the unit square. `list` gives wave numbers in u and v, and the
/// phase in turns.
fn waves(u: f64, v: f64, list: &[(f64, f64, f64)]) -> f64 {
    let sum: f64 = list.iter().map(|&(a, b, turn)| (TAU * (a * u + b * v + turn)).sin()).sum();
    sum / (list.len() as f64).sqrt()
}

/// The thickness profile of a tube: 1 where a wave crosses 0, falling to 0 at `width` on either side.
fn tube(wave: f64, width: f64) -> f64 {
    (1.0 - (wave / width).powi(2)).max(0.0).sqrt()
}

/// Skin, blood in veins of two widths, flesh to the full depth.
fn veins(u: f64, v: f64) -> [f64; 4] {
    let bend = 0.03 * waves(u, v, &[(3.0, 1.0, 0.1), (-2.0, 4.0, 0.6), (5.0, 3.0, 0.3)]);
    let (u, v) = (u + bend, v - bend);
    let large = waves(u, v, &[(2.0, 1.0, 0.2), (-1.0, 2.0, 0.7), (1.0, -3.0, 0.45)]);
    let small = waves(u, v, &[(5.0, 2.0, 0.9), (-3.0, 6.0, 0.15), (6.0, -5.0, 0.5), (-7.0, -2.0, 0.3)]);
    let blood = f64::max(0.45 * tube(large, 0.12), 0.2 * tube(small, 0.14));
    [0.2, 0.2 + blood, 1.0, 1.0]
}

/// Smoothstep: from 0 at `low` to 1 at `high`.
fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A fish from its side, head to the right: skin, blood that is thin over bones and gills, organs; eye and belly lie
/// near the surface.
fn fish(u: f64, v: f64) -> [f64; 4] {
    // x from tail to nose, y upwards.
    let (x, y) = (u - 0.5, 0.5 - v);
    let blob = |cx: f64, cy: f64, rx: f64, ry: f64| {
        let d = ((x - cx) / rx).hypot((y - cy) / ry);
        1.0 - smooth(0.75, 1.0, d)
    };
    let eye = blob(0.37, 0.035, 0.022, 0.022);
    let iris = blob(0.37, 0.035, 0.045, 0.045) - eye;
    let belly = f64::max(blob(0.13, -0.05, 0.13, 0.055), blob(0.24, -0.02, 0.05, 0.05));
    // Ribs that lean back from the spine, the spine itself, and the rays of the tail fin.
    let body = smooth(-0.36, -0.3, x) * (1.0 - smooth(0.22, 0.27, x));
    let ribs =
        smooth(0.35, 0.9, (TAU * 22.0 * (x + 0.35 * y.abs())).sin()) * body * (1.0 - smooth(0.09, 0.13, y.abs()));
    let spine = (1.0 - smooth(0.006, 0.012, (y - 0.012).abs())) * body;
    let rays =
        smooth(0.0, 0.8, (TAU * 26.0 * (y / (0.62 + x).max(0.05)) * 0.25).sin()) * (1.0 - smooth(-0.42, -0.36, x));
    let gills = [0.24, 0.265, 0.29].map(|c| {
        let arc = (x - c - 0.5 * y * y * 8.0).abs();
        (1.0 - smooth(0.004, 0.009, arc)) * (1.0 - smooth(0.06, 0.09, y.abs()))
    });
    let gills = gills.into_iter().fold(0.0, f64::max);
    let bones = ribs.max(spine).max(rays).max(gills);
    let blood = (0.34 - 0.26 * bones + 0.12 * iris) * (1.0 - 0.93 * eye.max(0.8 * belly));
    let organs = 1.0 - 0.35 * eye;
    [0.12, 0.12 + blood, organs, 1.0]
}

/// A thin skin of small scales, spots beneath them, flesh.
fn skin(u: f64, v: f64) -> [f64; 4] {
    let (a, b) = (TAU * 12.0 * u, TAU * 12.0 * v);
    let bump = 0.5 + 0.25 * (a.sin() * b.sin() + (0.5 * (a + b)).sin() * (0.5 * (a - b)).cos());
    let spots = smooth(0.3, 0.6, waves(u, v, &[(2.0, 1.0, 0.3), (-1.0, 3.0, 0.8), (3.0, -2.0, 0.1)]));
    let scales = 0.1 + 0.22 * bump;
    [scales, scales + 0.05 + 0.4 * spots, 1.0, 1.0]
}
