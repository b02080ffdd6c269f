//! Materials by name: measured ones of two papers, and looks that were chosen by eye.

mod coefficients;

pub use coefficients::{LIQUIDS, LOOKS, PRESETS};

use super::locate;
use crate::error::Input;

/// Where a material's coefficients are from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Provenance {
    /// Measured: Jensen, Marschner, Levoy, Hanrahan 2001, "A practical model for subsurface light transport",
    /// figure 5.
    Jensen2001,
    /// Measured in dilution: Narasimhan, Gupta, Donner, Ramamoorthi, Nayar, Jensen 2006, "Acquiring scattering
    /// properties of participating media by dilution"; the index is water's.
    Narasimhan2006,
    /// Chosen by eye, not measured.
    Look,
}

impl Provenance {
    /// A few words for a table.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Jensen2001 => "measured, Jensen 2001",
            Self::Narasimhan2006 => "measured, Narasimhan 2006",
            Self::Look => "a look, not measured",
        }
    }
}

/// One material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// The name in the paper's table.
    pub name: &'static str,
    /// Where its coefficients are from.
    pub origin: Provenance,
    /// Reduced scattering coefficient per mm, r g b.
    pub sigma_s_prime: [f64; 3],
    /// Absorption coefficient per mm, r g b.
    pub sigma_a: [f64; 3],
    /// Relative index of refraction.
    pub eta: f64,
    /// Diffuse reflectance as printed in the paper, r g b, 0 to 1, where it is; for comparison only.
    pub diffuse_reflectance: Option<[f64; 3]>,
    /// sigma_0 of the CDRF, mm, r g b: the fit to the dipole over balls, as `milkglass fit-cdrf` computes it.
    pub sigma_0: [f64; 3],
}

impl Preset {
    /// Every preset: those of Jensen et al., those of Narasimhan et al., and the looks.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        PRESETS.iter().chain(LIQUIDS).chain(LOOKS)
    }

    /// Their names, in that order.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        Self::all().map(|preset| preset.name).collect()
    }

    /// The preset of this name; case, spaces, hyphens and underscores are ignored.
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::all().find(|preset| plain(preset.name) == plain(name))
    }

    /// The preset of this name, or an error at this key with the nearest name and the list of all.
    pub fn find(name: &str, key: &str) -> Result<&'static Self, Input> {
        Self::named(name).ok_or_else(|| {
            let names = Self::names();
            let what = locate::with_suggestion("unknown preset", name, &names);
            Input::new(what).key(key).found(name).expected(names.join(", "))
        })
    }
}

/// A name in lower case, without spaces, hyphens and underscores.
fn plain(name: &str) -> String {
    let kept = name.chars().filter(|c| !matches!(c, ' ' | '-' | '_'));
    kept.flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_forgiving() {
        for name in ["wholemilk", "Whole milk", "WHOLE-MILK", "whole_milk"] {
            assert_eq!(Preset::named(name).map(|p| p.name), Some("Wholemilk"));
        }
        assert_eq!(Preset::named("whole"), None);
        assert_eq!(Preset::named("lowfat soy-milk").map(|p| p.origin), Some(Provenance::Narasimhan2006));
        assert_eq!([PRESETS.len(), LIQUIDS.len(), LOOKS.len()], [12, 8, 4]);
        let mut names: Vec<String> = Preset::all().map(|preset| plain(preset.name)).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 24, "each name is one preset's");
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
                let error = (dipole - preset.diffuse_reflectance.unwrap_or([f64::NAN; 3])[c]).abs();
                assert!(error < 0.035, "{} channel {c}: {dipole}", preset.name);
            }
        }
    }
}
