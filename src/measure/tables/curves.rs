//! Figures 3 and 4: the form factor of a triangle in the receiving point's plane, with a corner (the tip) towards the
//! point.
//!
//! Each point has the near-exact value, the paper's evaluation, ours, and the standard deviation of random samples.

use glam::DVec3;

use super::segments::{Segmented, form_factor};
use crate::dipole::form_factor::edge::edge_form;
use crate::dipole::form_factor::exact::edge_form_exact;
use crate::dipole::form_factor::ladder::Ladder;
use crate::dipole::form_factor::points::{SIX, THREE, TWELVE, midpoint_moment, sampled, trace};
use crate::dipole::form_factor::{Distance, gauss, vector_area};
use crate::dipole::profile::Dipole;
use crate::prepare::material::dipoles;
use crate::scene::{Fresnel, Material, PRESETS, Preset, Surface};
use crate::transport::links::reach::reach2;

/// Tolerances of our quadrature rules in the figures: the default, and the finest.
pub const TOLERANCES: [f64; 2] = [1e-2, 1e-4];

/// One point of a curve in one channel.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// 0, 1, 2 for r, g, b.
    pub channel: usize,
    /// Figure 3: distance from the receiving point to the tip; figure 4: to the base; millimetres.
    pub place: f64,
    /// The near-exact form factor.
    pub exact: f64,
    /// The paper's evaluation, with both parts of condition 19.
    pub paper: Segmented,
    /// The paper's evaluation without the part of condition 19 that contains sigma.
    pub loose: Segmented,
    /// Ours at [`TOLERANCES`]: kernel evaluations per source, and the value.
    pub ours: [(usize, f64); 2],
    /// Standard deviation of one uniform sample, relative to the value; for n samples divide by sqrt(n).
    pub scatter: f64,
    /// Number of samples by Jensen and Buhler's criterion: one per disc with a radius of one mean free path.
    pub discs: usize,
}

impl Point {
    /// Relative error of a value.
    #[must_use]
    pub fn error(&self, value: f64) -> f64 {
        value / self.exact - 1.0
    }
}

/// The triangle with its tip at `tip` on the x axis and its base across the axis at `base`, `width` wide.
fn triangle(tip: f64, base: f64, width: f64) -> [DVec3; 3] {
    let corner = |side: f64| DVec3::new(base, side * 0.5 * width, 0.0);
    [DVec3::new(tip, 0.0, 0.0), corner(-1.0), corner(1.0)]
}

/// A preset's dipoles, lengths in millimetres; the diffuse Fresnel reflectance is the paper's polynomial.
fn material(name: &str) -> [Dipole; 3] {
    let preset = Preset::named(name).unwrap_or(&PRESETS[0]);
    let (sigma_s_prime, sigma_a, eta) = (preset.sigma_s_prime, preset.sigma_a, [preset.eta; 3]);
    dipoles(
        &Material {
            opaque: None,
            name: name.into(),
            sigma_s_prime,
            sigma_a,
            eta,
            g: [0.0; 3],
            fresnel: Fresnel::Paper,
            two_sided: false,
            single_scattering: false,
            surface: Surface::default(),
            sigma_0: None,
            curvature_radius: None,
            sigma_0_texture: None,
            texture: None,
            layers: None,
        },
        1.0,
    )
}

/// Figure 3: skim milk; tip 0 to 10 mm away in steps of 0.2 mm, base 10 mm wide, height 5 mm.
#[must_use]
pub fn figure_3() -> Vec<Point> {
    let tips = (0..=50).map(|k| 0.2 * f64::from(k));
    curve("skimmilk", tips.map(|tip| (tip, triangle(tip, tip + 5.0, 10.0))))
}

/// Figure 4: marble; tip at the receiving point, base 0.1 to 100 mm away in tenths of a decade, twice as wide as its
/// distance.
#[must_use]
pub fn figure_4() -> Vec<Point> {
    let bases = (-10..=20).map(|k| 10f64.powf(0.1 * f64::from(k)));
    curve("marble", bases.map(|base| (base, triangle(0.0, base, 2.0 * base))))
}

fn curve(name: &str, triangles: impl Iterator<Item = (f64, [DVec3; 3])> + Clone) -> Vec<Point> {
    let media = material(name);
    (0..3).flat_map(|c| triangles.clone().map(move |(place, t)| point(c, place, &t, &media))).collect()
}

fn point(channel: usize, place: f64, triangle: &[DVec3; 3], media: &[Dipole; 3]) -> Point {
    let (x, dipole, area) = (DVec3::ZERO, &media[channel], vector_area(triangle).length());
    let exact = edge_form_exact(triangle, [0, 1, 2], x, dipole, Distance::Radial);
    let square = area * square(triangle, dipole);
    Point {
        channel,
        place,
        exact,
        paper: form_factor(triangle, x, dipole, true),
        loose: form_factor(triangle, x, dipole, false),
        ours: TOLERANCES.map(|tolerance| ours(triangle, x, media, dipole, tolerance)),
        scatter: (square / (exact * exact) - 1.0).max(0.0).sqrt(),
        discs: (area / (std::f64::consts::PI * dipole.z_real * dipole.z_real)).ceil() as usize,
    }
}

/// The evaluation by the stages `reach` and `form_factor`, in `f64`: evaluations per source, and the value.
fn ours(triangle: &[DVec3; 3], x: DVec3, media: &[Dipole; 3], dipole: &Dipole, tolerance: f64) -> (usize, f64) {
    let d2 = (triangle.iter().sum::<DVec3>() / 3.0).distance_squared(x);
    let far = |chi: f64| media.iter().map(|m| reach2(trace(triangle), m, chi, false)).fold(0.0, f64::max);
    let rule = Ladder::new(tolerance).chi.iter().position(|&chi| d2 >= far(chi));
    let points = |rule: &[_]| (rule.len(), sampled(triangle, x, dipole, Distance::Radial, rule));
    match rule {
        Some(0) => (1, midpoint_moment(triangle, x, dipole, Distance::Radial)),
        Some(1) => points(&THREE),
        Some(2) => points(&SIX),
        Some(_) => points(&TWELVE),
        None => (18, edge_form(triangle, [0, 1, 2], x, dipole, Distance::Radial, &gauss::SIX)),
    }
}

/// The integral of R_d squared over a triangle seen from the origin: 12 points on each part, subdivided until no edge
/// is longer than half the part's distance.
fn square(triangle: &[DVec3; 3], dipole: &Dipole) -> f64 {
    let [a, b, c] = *triangle;
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let distance = ((a + b + c) / 3.0).length().hypot(dipole.z_real);
    if longest > 0.5 * distance {
        let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
        return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].iter().map(|part| square(part, dipole)).sum();
    }
    let place = |s: &[f64; 4]| s[0] * a + s[1] * b + s[2] * c;
    let mean: f64 = TWELVE.iter().map(|s| s[3] * dipole.radial(place(s).length_squared()).powi(2)).sum();
    vector_area(triangle).length() * mean
}
