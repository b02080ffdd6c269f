//! Local shading of a scene: the shading function, sigma_0 and k_d.

use crate::dipole::profile::Dipole;
use crate::lighting::fresnel;
use crate::scene::{self, Cdrf, Material};
use crate::state::Local;
use crate::state::options::ShadingMethod;

/// The local shading that replaces transport, if any.
#[must_use]
pub fn local(settings: &scene::Transport, transport: ShadingMethod) -> Option<Local> {
    match (transport, settings.cdrf) {
        (ShadingMethod::Lambert, _) => Some(Local::Lambert),
        (ShadingMethod::TextureBlur, _) => Some(Local::Blur),
        (ShadingMethod::Cdrf, Cdrf::Closed) => Some(Local::Closed),
        (ShadingMethod::Cdrf, Cdrf::Table) => Some(Local::Table(settings.cdrf_table)),
        _ => None,
    }
}

/// The largest default sigma_0, in mean free paths.
pub const WIDEST: f64 = 10.0;

/// The default sigma_0: the standard deviation, along one axis, of the dipole's profile, sqrt(z / sigma_tr), with z
/// the mean of the sources' distances weighted by the light of each. Length; at most [`WIDEST`] mean free paths: at
/// low absorption the profile's far tail dominates, for which few objects are large enough.
#[must_use]
pub fn default_sigma_0(dipole: &Dipole) -> f64 {
    let weights = dipole.depths().map(|z| (-dipole.sigma * z).exp());
    let mean = (weights[0] * dipole.z_real + weights[1] * dipole.z_virtual) / (weights[0] + weights[1]);
    (mean / dipole.sigma).sqrt().min(WIDEST * dipole.z_real)
}

/// sigma_0, the material's own in scene units or else the default in the dipoles' units; and k_d, (1 - F_ext) times
/// the dipole's total reflectance.
pub(crate) fn coefficients(material: &Material, dipoles: Option<&[Dipole; 3]>) -> ([f64; 3], [f64; 3]) {
    let of = |f: &dyn Fn(&Dipole) -> f64| dipoles.map_or([0.0; 3], |dipoles| dipoles.each_ref().map(f));
    let (spread, total) = (of(&default_sigma_0), of(&Dipole::total));
    let enters = material.eta.map(|eta| 1.0 - fresnel::diffuse_external_exact(eta));
    (material.sigma_0.unwrap_or(spread), [0, 1, 2].map(|c| enters[c] * total[c]))
}

#[cfg(test)]
mod tests {
    use crate::prepare::shading::*;
    use std::f64::consts::PI;

    #[test]
    fn the_spread_is_the_profiles_own() {
        let dipole = Dipole::new(2.19, 0.0021, 3.96);
        // Half the mean square distance between entry and exit.
        let (mut sum, mut whole) = (0.0, 0.0);
        for k in 0..400_000 {
            let r = 2e-3 * (f64::from(k) + 0.5);
            let ring = 2.0 * PI * r * dipole.reflectance(r) * 2e-3;
            (sum, whole) = (sum + 0.5 * r * r * ring, whole + ring);
        }
        let expected = (sum / whole).sqrt();
        assert!((default_sigma_0(&dipole) / expected - 1.0).abs() < 1e-4, "{} {expected}", default_sigma_0(&dipole));
        let clear = Dipole::new(2.0, 0.0, 3.0);
        assert_eq!(default_sigma_0(&clear), 10.0 * clear.z_real);
    }
}
