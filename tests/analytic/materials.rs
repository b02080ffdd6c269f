//! The twelve materials of Jensen et al. 2001 (figure 5), with the diffuse reflectance printed there.

use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::lighting::fresnel;

/// One row of the table, channels in the order red, green, blue.
pub struct Material {
    pub name: &'static str,
    /// Reduced scattering, 1/mm.
    pub scattering: [f64; 3],
    /// Absorption, 1/mm.
    pub absorption: [f64; 3],
    /// Diffuse reflectance as printed, to two digits.
    pub reflectance: [f64; 3],
    /// Relative index of refraction.
    pub eta: f64,
}

impl Material {
    /// The dipole of one channel, with the polynomial boundary term that the paper used.
    pub fn dipole(&self, channel: usize) -> Dipole {
        let a = fresnel::boundary(fresnel::diffuse_internal_polynomial(self.eta));
        Dipole::new(self.scattering[channel], self.absorption[channel], a)
    }
}

/// All 36 channels, each with its material's name and printed reflectance.
pub fn channels() -> impl Iterator<Item = (String, Dipole, f64)> {
    MATERIALS
        .iter()
        .flat_map(|m| (0..3).map(|k| (format!("{} {}", m.name, ["R", "G", "B"][k]), m.dipole(k), m.reflectance[k])))
}

const fn row(
    name: &'static str,
    scattering: [f64; 3],
    absorption: [f64; 3],
    reflectance: [f64; 3],
    eta: f64,
) -> Material {
    Material { name, scattering, absorption, reflectance, eta }
}

/// The table.
pub const MATERIALS: [Material; 12] = [
    row("Apple", [2.29, 2.39, 1.97], [0.003, 0.0034, 0.046], [0.85, 0.84, 0.53], 1.3),
    row("Chicken1", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19], [0.31, 0.15, 0.1], 1.3),
    row("Chicken2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.2], [0.32, 0.16, 0.1], 1.3),
    row("Cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163], [0.98, 0.9, 0.73], 1.3),
    row("Ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45], [0.16, 0.01, 0.0], 1.3),
    row("Marble", [2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071], [0.83, 0.79, 0.75], 1.5),
    row("Potato", [0.68, 0.7, 0.55], [0.0024, 0.009, 0.12], [0.77, 0.62, 0.21], 1.3),
    row("Skimmilk", [0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142], [0.81, 0.81, 0.69], 1.3),
    row("Skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48], [0.44, 0.22, 0.13], 1.3),
    row("Skin2", [1.09, 1.59, 1.79], [0.013, 0.07, 0.145], [0.63, 0.44, 0.34], 1.3),
    row("Spectralon", [11.6, 20.4, 14.9], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], 1.3),
    row("Wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014], [0.91, 0.88, 0.76], 1.3),
];
