//! Closed forms: single scattering in a flat slab of uniform layers below z = 0, seen at the origin.

use glam::DVec3;

use super::beneath::phase;

/// One layer of a slab, one colour channel. Layers are listed from the surface down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabLayer {
    /// Scattering coefficient, 1/length, at least 0.
    pub sigma_s: f64,
    /// Extinction coefficient, 1/length, at least `sigma_s`.
    pub sigma_t: f64,
    /// Schlick's k, above -1 and below 1.
    pub g: f64,
    /// Thickness, length, at least 0.
    pub thickness: f64,
}

/// The light on a slab, from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lamp {
    /// The unit direction towards it, z above 0, and its irradiance on a plane that faces it.
    Directional(DVec3, f64),
    /// Its position, z above 0, and its intensity; it falls off with the squared distance to the scattering point.
    Point(DVec3, f64),
}

/// Radiance at the origin along the unit direction `eye`, z above 0: no refraction, no Fresnel terms.
///
/// For a directional light, layer by layer, with tau the optical depth of the layers above: sigma_s p E e^(-tau
/// (1/mu_i + 1/mu_o)) (1 - e^(-sigma_t D (1/mu_i + 1/mu_o))) / (sigma_t (1/mu_i + 1/mu_o) mu_o). For a point light
/// the same integral over the depth, by 20-point Gauss-Legendre quadrature on parts of at most a quarter of a mean
/// free path or of the lamp's height, to about 1e-12.
#[must_use]
pub fn radiance(layers: &[SlabLayer], lamp: Lamp, eye: DVec3) -> f64 {
    let (mut sum, mut top, mut tau) = (0.0, 0.0, 0.0);
    for layer in layers {
        sum += match lamp {
            Lamp::Directional(toward, irradiance) => {
                let rate = 1.0 / toward.z + 1.0 / eye.z;
                let depth = layer.sigma_t * layer.thickness * rate;
                // (1 - e^-x) / x, times the thickness.
                let share = if depth > 0.0 { -(-depth).exp_m1() / depth } else { 1.0 };
                let scattered = layer.sigma_s * phase(false, layer.g, toward.dot(eye)) * irradiance;
                scattered * (-tau * rate).exp() * share * layer.thickness / eye.z
            }
            Lamp::Point(place, intensity) => {
                let at = |z: f64| {
                    let toward = place - eye * (-z / eye.z);
                    let d2 = toward.length_squared();
                    let toward = toward / d2.sqrt();
                    let depth = tau + layer.sigma_t * (z - top);
                    let dimmed = (-depth * (1.0 / toward.z + 1.0 / eye.z)).exp();
                    layer.sigma_s * phase(false, layer.g, toward.dot(eye)) * intensity / d2 * dimmed / eye.z
                };
                let scale = 0.25 * f64::min(eye.z / layer.sigma_t.max(1e-300), place.z * eye.z);
                integral(at, top, top + layer.thickness, scale)
            }
        };
        top += layer.thickness;
        tau += layer.sigma_t * layer.thickness;
    }
    sum
}

/// Positive nodes and weights of the 20-point Gauss-Legendre rule; it is symmetric about 0.
const GAUSS: [[f64; 2]; 10] = [
    [0.076_526_521_133_497_33, 0.152_753_387_130_725_85],
    [0.227_785_851_141_645_08, 0.149_172_986_472_603_75],
    [0.373_706_088_715_419_56, 0.142_096_109_318_382_05],
    [0.510_867_001_950_827_1, 0.131_688_638_449_176_63],
    [0.636_053_680_726_515, 0.118_194_531_961_518_42],
    [0.746_331_906_460_150_8, 0.101_930_119_817_240_44],
    [0.839_116_971_822_218_8, 0.083_276_741_576_704_75],
    [0.912_234_428_251_326, 0.062_672_048_334_109_06],
    [0.963_971_927_277_913_8, 0.040_601_429_800_386_94],
    [0.993_128_599_185_094_9, 0.017_614_007_139_152_118],
];

/// The integral of `f` from `low` to `high`: at most 3000 equal parts, of at most `scale` each, and one part for the
/// rest. Light from deeper than 700 mean free paths is negligible.
fn integral(f: impl Fn(f64) -> f64, low: f64, high: f64, scale: f64) -> f64 {
    let (mut sum, mut from) = (0.0, low);
    let end = high.min(low + 3000.0 * scale);
    let parts = ((end - from) / scale).ceil().clamp(1.0, 3000.0);
    let step = (end - from) / parts;
    for _ in 0..parts as u32 {
        let (middle, half) = (from + 0.5 * step, 0.5 * step);
        let pair = |[x, w]: &[f64; 2]| w * (f(middle - half * x) + f(middle + half * x));
        sum += half * GAUSS.iter().map(pair).sum::<f64>();
        from += step;
    }
    // The rest, in one part: a thin layer under a low lamp, where the integrand falls off smoothly.
    if end < high {
        let (middle, half) = (f64::midpoint(end, high), 0.5 * (high - end));
        sum += half * GAUSS.iter().map(|[x, w]| w * (f(middle - half * x) + f(middle + half * x))).sum::<f64>();
    }
    sum
}
