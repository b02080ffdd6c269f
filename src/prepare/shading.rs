//! Local shading of a scene: the shading function, sigma_0 and k_d.

use crate::dipole::profile::Dipole;
use crate::layout::Buffers;
use crate::lighting::fresnel;
use crate::scene::{self, Cdrf, Fresnel, Material, Preset};
use crate::shading::balls::usual::fitted;
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

/// sigma_0 of each channel of a translucent material in 1 / the unit of its coefficients: its own, or else the fit to
/// the dipole, tabled for presets.
#[must_use]
pub fn sigma_0(material: &Material) -> [f64; 3] {
    material.sigma_0.or_else(|| tabled(material)).unwrap_or_else(|| fit(material))
}

/// The default radius within which curvature is smoothed, over the mean of sigma_0.
pub const SMOOTHING: f64 = 2.0;

/// The largest radius of smoothing, and the smallest one that is not 0, in internal units: the scene at rest is 1
/// across. Beyond, squares would leave `f32`, and nothing would change.
const RADII: [f64; 2] = [16.0, 1e-5];

/// Radius within which curvature is smoothed, in internal units of `length`: the material's own, or else
/// [`SMOOTHING`] times the mean of sigma_0 over the channels.
pub(crate) fn curvature_radius(material: &Material, sigma_0: [f64; 3], length: f64) -> f32 {
    let usual = || SMOOTHING * sigma_0.iter().map(|sigma| sigma / 3.0).sum::<f64>();
    let radius = material.curvature_radius.unwrap_or_else(usual) * length;
    if radius < RADII[1] { 0.0 } else { radius.min(RADII[0]) as f32 }
}

/// The vertices of one object in the order of their first triangles, those without any last.
pub(crate) fn vertex_order(data: &Buffers) -> Vec<u32> {
    let first = |vertex: usize| {
        data.corners[data.corner_starts[vertex] as usize..data.corner_starts[vertex + 1] as usize].iter().min()
    };
    let mut order: Vec<u32> = (0..data.corner_starts.len() as u32 - 1).collect();
    order.sort_by_key(|&vertex| (first(vertex as usize).copied().unwrap_or(u32::MAX), vertex));
    order
}

/// The fit to the dipole over balls, computed once per material.
#[must_use]
pub fn fit(material: &Material) -> [f64; 3] {
    fitted(material.sigma_s_prime, material.sigma_a, boundaries(material))
}

/// The fit of a preset's table, if the material is that preset at any scale.
fn tabled(material: &Material) -> Option<[f64; 3]> {
    let alike = |preset: &&Preset| {
        let scale = material.sigma_s_prime[0] / preset.sigma_s_prime[0];
        let near = |own: f64, other: f64| (own - scale * other).abs() <= 1e-9 * own;
        let same = |own: [f64; 3], other: [f64; 3]| own.into_iter().zip(other).all(|(own, other)| near(own, other));
        scale > 0.0
            && material.fresnel == Fresnel::Exact
            && material.eta == [preset.eta; 3]
            && same(material.sigma_s_prime, preset.sigma_s_prime)
            && same(material.sigma_a, preset.sigma_a)
    };
    let preset = Preset::all().find(alike)?;
    Some(preset.sigma_0.map(|length| length * preset.sigma_s_prime[0] / material.sigma_s_prime[0]))
}

/// The A of each channel's boundary.
pub fn boundaries(material: &Material) -> [f64; 3] {
    material.eta.map(|eta| {
        fresnel::boundary(match material.fresnel {
            Fresnel::Exact => fresnel::diffuse_internal_exact(eta),
            Fresnel::Paper => fresnel::diffuse_internal_polynomial(eta),
        })
    })
}

/// k_d of each channel: (1 - F_ext) times the dipole's total reflectance; 0 without dipoles.
pub(crate) fn diffuse(material: &Material, dipoles: Option<&[Dipole; 3]>) -> [f64; 3] {
    let total = dipoles.map_or([0.0; 3], |dipoles| dipoles.each_ref().map(Dipole::total));
    let enters = material.eta.map(|eta| 1.0 - fresnel::diffuse_external_exact(eta));
    [0, 1, 2].map(|c| enters[c] * total[c])
}

#[cfg(test)]
mod tests {
    use crate::prepare::shading::*;
    use crate::scene::Scene;

    fn material(keys: &[&str]) -> Material {
        let sets: Vec<String> = keys.iter().map(|key| format!("object.0.material.{key}")).collect();
        Scene::load_with("sphere", &sets).expect("a sphere").objects[0].material.clone()
    }

    #[test]
    fn the_table_of_presets_is_the_fit() {
        for preset in Preset::all() {
            let material = material(&[&format!("preset='{}'", preset.name.to_lowercase()), "scale=2.5"]);
            let (table, found) = (sigma_0(&material), fit(&material));
            (0..3).for_each(|c| assert!((table[c] / found[c] - 1.0).abs() < 1e-3, "{}: {found:?}", preset.name));
            assert_eq!(Some(table), tabled(&material));
            // A paper's polynomial for the boundary is another boundary.
            assert_eq!(tabled(&Material { fresnel: Fresnel::Paper, ..material.clone() }), None);
        }
        let marble = sigma_0(&material(&["preset=marble"]));
        [1.68, 1.34, 1.18].into_iter().zip(marble).for_each(|(told, own)| assert!((told - own).abs() < 0.006));
    }

    #[test]
    fn another_material_is_fitted_and_its_own_value_wins() {
        let other = material(&["preset=marble", "sigma_a=[0.0021, 0.0041, 0.0072]"]);
        assert_eq!(tabled(&other), None);
        let (own, marble) = (sigma_0(&other), sigma_0(&material(&["preset=marble"])));
        assert!((own[0] / marble[0] - 1.0).abs() < 1e-3 && own[2] < marble[2], "{own:?} {marble:?}");
        assert_eq!(sigma_0(&material(&["preset=marble", "sigma_0=[3, 2, 0]"])), [3.0, 2.0, 0.0]);
    }
}
