//! Materials: the parameters of an object that depend on its material, for a new state or a change of the material.

use super::blocks::{edge_nodes, triangle_size};
use super::rounding::rounding;
use super::shading;
use super::units::Units;
use crate::dipole::profile::Dipole;
use crate::layout::{ObjectParams, REFLECTION_GGX, REFLECTION_NONE, REFLECTION_PHONG};
use crate::lighting::{fresnel, harmonics};
use crate::scene::{DENSEST, Material, Reflection, Scene};
use crate::state::{Change, Local, State};

/// The smallest reduced extinction in internal units; thinner materials are scaled up to it. They reflect too little
/// light to be seen, but powers of the source depths stay within `f32`, and so does the product of their squares.
const THINNEST: f64 = 1e-8;

/// The dipole of each channel in internal units. A material denser than [`DENSEST`] is scaled down to it, with its
/// albedo kept: light leaves where it enters, as far as `f32` positions can tell.
pub fn dipoles(material: &Material, length: f64) -> [Dipole; 3] {
    let boundary = shading::boundaries(material);
    std::array::from_fn(|channel| {
        let (scattering, absorption) = (material.sigma_s_prime[channel], material.sigma_a[channel]);
        let limit = |extinction: f64| extinction * length / (scattering + absorption);
        let change = limit(DENSEST).min(1.0).max(limit(THINNEST));
        let coefficient = |value: f64| value * change / length;
        Dipole::new(coefficient(scattering), coefficient(absorption), boundary[channel])
    })
}

/// Sets the parameters that depend on the material alone.
pub(super) fn coefficients(params: &mut ObjectParams, material: &Material, units: Units, local: Option<Local>) {
    // Opaque materials have no dipole.
    let dipoles = material.opaque.is_none().then(|| dipoles(material, units.length));
    let per_channel =
        |f: fn(&Dipole) -> f64| dipoles.as_ref().map_or([0.0; 3], |d| d.each_ref().map(|dipole| f(dipole) as f32));
    let (reflection, lobes) = match material.surface.reflection {
        Reflection::None => (REFLECTION_NONE, [0.0; 3]),
        Reflection::Phong { shininess } => (REFLECTION_PHONG, [shininess.into(), 0.0, 0.0]),
        Reflection::Ggx { roughness, second_roughness, second_share } => {
            (REFLECTION_GGX, [roughness, second_roughness, second_share])
        }
    };
    let [roughness, second_roughness, second_share] = lobes.map(|x| x as f32);
    let facet_tilt = match material.surface.reflection {
        // Lighter than what is around it, light may be reflected whole at any facet: no one cosine stands for them.
        Reflection::Ggx { roughness, second_roughness, second_share } if material.eta.iter().all(|eta| *eta >= 1.0) => {
            let [first, second] = [roughness, second_roughness].map(fresnel::facet_tilt);
            first + second_share * (second - first)
        }
        _ => 0.0,
    };
    let exit = |eta: f64| if material.surface.normalize_exit { fresnel::exit(eta, facet_tilt) as f32 } else { 1.0 };
    let diffuse = shading::diffuse(material, dipoles.as_ref());
    let bent = matches!(local, Some(Local::Closed | Local::Table(_))) && material.opaque.is_none();
    let sigma_0 = if bent { shading::sigma_0(material) } else { [0.0; 3] };
    let zonal = material.eta.map(harmonics::zonal);
    let degree = |l: usize| zonal.map(|factors| factors[l] as f32);
    *params = ObjectParams {
        albedo: material.opaque.unwrap_or_default().map(|share| share as f32),
        strength: per_channel(|d| d.strength),
        sigma: per_channel(|d| d.sigma),
        z_real: per_channel(|d| d.z_real),
        z_virtual: per_channel(|d| d.z_virtual),
        eta: material.eta.map(|eta| eta as f32),
        reflection,
        roughness,
        second_roughness,
        second_share,
        facet_tilt: facet_tilt as f32,
        exit: material.eta.map(exit),
        two_sided: u32::from(material.two_sided),
        zonal_0: degree(0),
        zonal_1: degree(1),
        zonal_2: degree(2),
        // Kept finite in `f32`, so that its product with a curvature of 0 is 0.
        sigma_0: sigma_0.map(|sigma| (sigma * units.length).min(1e30) as f32),
        curvature_radius: if bent { shading::curvature_radius(material, sigma_0, units.length) } else { 0.0 },
        diffuse: diffuse.map(|share| share as f32),
        ..*params
    };
    if material.opaque.is_none() {
        super::diffusion::boundary(params);
    }
}

/// Whether a state stays as it is but for coefficients when this material takes the place of that one.
pub(crate) fn differs_by_coefficients(before: &Material, after: &Material, local: Option<Local>) -> bool {
    let same = before.opaque.is_some() == after.opaque.is_some()
        && before.texture == after.texture
        && before.sigma_0_texture == after.sigma_0_texture
        && before.layers == after.layers
        && before.single_scattering == after.single_scattering
        && (before.eta == after.eta || !before.single_scattering);
    // The Gaussians of texture-blur are buffers.
    same && local != Some(Local::Blur)
}

/// Sets the coefficients of an object's material in a state of the same scene; returns what they change.
pub(crate) fn change(state: &mut State, number: usize, material: &Material, units: Units) -> Change {
    let before = state.data.object_params[number];
    coefficients(&mut state.data.object_params[number], material, units, state.method.local);
    rounding(state, number);
    let after = state.data.object_params[number];

    // What only pictures show, then how light spreads; the rest decides how much enters.
    let shown = ObjectParams {
        reflection: after.reflection,
        roughness: after.roughness,
        second_roughness: after.second_roughness,
        second_share: after.second_share,
        facet_tilt: after.facet_tilt,
        exit: after.exit,
        ..before
    };
    let spread = ObjectParams {
        strength: after.strength,
        sigma: after.sigma,
        z_real: after.z_real,
        z_virtual: after.z_virtual,
        boundary: after.boundary,
        sky_depth: after.sky_depth,
        rounding: after.rounding,
        sigma_0: after.sigma_0,
        curvature_radius: after.curvature_radius,
        diffuse: after.diffuse,
        ..shown
    };
    let differ = |a: &ObjectParams, b: &ObjectParams| bytemuck::bytes_of(a) != bytemuck::bytes_of(b);
    let enters = if differ(&spread, &after) { Change::LIGHT } else { Change::default() };
    let spreads = if differ(&shown, &spread) { Change::MATERIAL } else { Change::default() };
    let shows = if differ(&before, &shown) { Change::SURFACE } else { Change::default() };
    enters.and(spreads).and(shows)
}

/// Sets the quadrature of the edge form, for the largest triangles of all translucent objects; returns whether that
/// has changed.
pub(crate) fn quadrature(state: &mut State, scene: &Scene) -> bool {
    let translucent = (0..state.objects.len()).filter(|&number| !state.objects[number].opaque);
    let largest = translucent.map(|number| triangle_size(state, number)).fold(0.0, f64::max);
    let nodes = edge_nodes(scene.transport.tolerance, largest);
    std::mem::replace(&mut state.method.nodes, nodes) != nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Fresnel;

    #[test]
    fn squares_of_both_depths_have_a_product_in_f32() {
        for density in [1e-300, 1e300] {
            for (eta, fresnel) in [(0.5, Fresnel::Exact), (5.0, Fresnel::Exact), (3.8, Fresnel::Paper)] {
                let mut material = Scene::load("sphere").unwrap().objects.remove(0).material;
                (material.sigma_s_prime, material.sigma_a) = ([density; 3], [density; 3]);
                (material.eta, material.fresnel) = ([eta; 3], fresnel);
                let [depths, ..] = dipoles(&material, 1.0).map(|dipole| dipole.depths().map(|depth| depth as f32));
                let product = depths.map(|depth| depth * depth).iter().product::<f32>();
                assert!(product.is_normal() && (1.0 / product).is_normal(), "{density} {eta}: {product}");
            }
        }
    }
}
