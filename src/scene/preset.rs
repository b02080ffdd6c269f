//! The measured materials of Jensen, Marschner, Levoy, Hanrahan 2001, "A practical model for
//! subsurface light transport", figure 5.

/// One measured material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// The name in the paper's table.
    pub name: &'static str,
    /// Reduced scattering coefficient per mm, r g b.
    pub sigma_s_prime: [f64; 3],
    /// Absorption coefficient per mm, r g b.
    pub sigma_a: [f64; 3],
    /// Relative index of refraction.
    pub eta: f64,
    /// Diffuse reflectance as printed in the paper, r g b, 0 to 1; for comparison only.
    pub diffuse_reflectance: [f64; 3],
    /// sigma_0 of the CDRF, mm, r g b: the fit to the dipole over balls, as `milkglass fit-cdrf` computes it.
    pub sigma_0: [f64; 3],
}

impl Preset {
    /// The preset of this name; case, spaces, hyphens and underscores are ignored.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| plain(preset.name) == plain(name))
    }
}

/// A name in lower case, without spaces, hyphens and underscores.
fn plain(name: &str) -> String {
    let kept = name.chars().filter(|c| !matches!(c, ' ' | '-' | '_'));
    kept.flat_map(char::to_lowercase).collect()
}

/// Every preset, in the paper's order.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "Apple",
        sigma_s_prime: [2.29, 2.39, 1.97],
        sigma_a: [0.003, 0.0034, 0.046],
        eta: 1.3,
        diffuse_reflectance: [0.85, 0.84, 0.53],
        sigma_0: [1.5072, 1.4558, 1.1732],
    },
    Preset {
        name: "Chicken1",
        sigma_s_prime: [0.15, 0.21, 0.38],
        sigma_a: [0.015, 0.077, 0.19],
        eta: 1.3,
        diffuse_reflectance: [0.31, 0.15, 0.1],
        sigma_0: [10.0133, 4.1498, 1.9239],
    },
    Preset {
        name: "Chicken2",
        sigma_s_prime: [0.19, 0.25, 0.32],
        sigma_a: [0.018, 0.088, 0.2],
        eta: 1.3,
        diffuse_reflectance: [0.32, 0.16, 0.1],
        sigma_0: [8.1041, 3.5526, 2.0412],
    },
    Preset {
        name: "Cream",
        sigma_s_prime: [7.38, 5.47, 3.15],
        sigma_a: [0.0002, 0.0028, 0.0163],
        eta: 1.3,
        diffuse_reflectance: [0.98, 0.9, 0.73],
        sigma_0: [0.6126, 0.6902, 0.8896],
    },
    Preset {
        name: "Ketchup",
        sigma_s_prime: [0.18, 0.07, 0.03],
        sigma_a: [0.061, 0.97, 1.45],
        eta: 1.3,
        diffuse_reflectance: [0.16, 0.01, 0.0],
        sigma_0: [5.3261, 0.7877, 0.5365],
    },
    Preset {
        name: "Marble",
        sigma_s_prime: [2.19, 2.62, 3.0],
        sigma_a: [0.0021, 0.0041, 0.0071],
        eta: 1.5,
        diffuse_reflectance: [0.83, 0.79, 0.75],
        sigma_0: [1.6785, 1.3410, 1.1755],
    },
    Preset {
        name: "Potato",
        sigma_s_prime: [0.68, 0.7, 0.55],
        sigma_a: [0.0024, 0.009, 0.12],
        eta: 1.3,
        diffuse_reflectance: [0.77, 0.62, 0.21],
        sigma_0: [4.6174, 3.8137, 1.9949],
    },
    Preset {
        name: "Skimmilk",
        sigma_s_prime: [0.7, 1.22, 1.9],
        sigma_a: [0.0014, 0.0025, 0.0142],
        eta: 1.3,
        diffuse_reflectance: [0.81, 0.81, 0.69],
        sigma_0: [5.0604, 2.8168, 1.6385],
    },
    Preset {
        name: "Skin1",
        sigma_s_prime: [0.74, 0.88, 1.01],
        sigma_a: [0.032, 0.17, 0.48],
        eta: 1.3,
        diffuse_reflectance: [0.44, 0.22, 0.13],
        sigma_0: [2.6180, 1.3086, 0.7549],
    },
    Preset {
        name: "Skin2",
        sigma_s_prime: [1.09, 1.59, 1.79],
        sigma_a: [0.013, 0.07, 0.145],
        eta: 1.3,
        diffuse_reflectance: [0.63, 0.44, 0.34],
        sigma_0: [2.2719, 1.2323, 0.8934],
    },
    Preset {
        name: "Spectralon",
        sigma_s_prime: [11.6, 20.4, 14.9],
        sigma_a: [0.0, 0.0, 0.0],
        eta: 1.3,
        diffuse_reflectance: [1.0, 1.0, 1.0],
        sigma_0: [0.4128, 0.2161, 0.2741],
    },
    Preset {
        name: "Wholemilk",
        sigma_s_prime: [2.55, 3.21, 3.77],
        sigma_a: [0.0011, 0.0024, 0.014],
        eta: 1.3,
        diffuse_reflectance: [0.91, 0.88, 0.76],
        sigma_0: [1.4507, 1.1145, 0.8831],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_forgiving() {
        for name in ["wholemilk", "Whole milk", "WHOLE-MILK", "whole_milk"] {
            assert_eq!(Preset::named(name).map(|p| p.name), Some("Wholemilk"));
        }
        assert_eq!(Preset::named("whole"), None);
        assert_eq!(PRESETS.len(), 12);
    }

    #[test]
    fn reflectances_follow_from_the_coefficients() {
        // The dipole's diffuse reflectance, equation 15 of the paper integrated over the plane.
        for preset in PRESETS {
            let fdr = -1.440 / preset.eta.powi(2) + 0.710 / preset.eta + 0.668 + 0.0636 * preset.eta;
            let a = (1.0 + fdr) / (1.0 - fdr);
            for c in 0..3 {
                let albedo = preset.sigma_s_prime[c] / (preset.sigma_s_prime[c] + preset.sigma_a[c]);
                let root = (3.0 * (1.0 - albedo)).sqrt();
                let dipole = albedo / 2.0 * (1.0 + (-4.0 / 3.0 * a * root).exp()) * (-root).exp();
                let error = (dipole - preset.diffuse_reflectance[c]).abs();
                assert!(error < 0.035, "{} channel {c}: {dipole}", preset.name);
            }
        }
    }
}
