//! The media that scatter light once, as stage `single_scattering` reads them.

use super::units::Units;
use crate::error::{Input, Result};
use crate::layout::ScatteringMedium;
use crate::scene::{Material, Object};
use crate::state::State;
use crate::state::options::ShadingMethod;

/// The largest extinction, per internal length: beyond it light goes no farther than `f32` can distinguish positions.
const DENSEST: f64 = 1e5;
/// Light attenuated below this share is ignored.
const FAINTEST: f64 = 1e-4;

/// Refuses single scattering beside a transport that holds it already.
pub(crate) fn beside(objects: &[Object], transport: ShadingMethod) -> Result<()> {
    let asks = objects.iter().position(|object| object.material.single_scattering);
    match asks {
        Some(number) if matches!(transport, ShadingMethod::Walk | ShadingMethod::Diffusion) => {
            let what = "random walk and diffusion hold the light that is scattered once; it would count twice";
            let fault = Input::new(what).key(format!("object.{number}.material.single_scattering"));
            Err(fault.found("true").expected("false, or another --transport than walk or diffusion").into())
        }
        _ => Ok(()),
    }
}

/// Sets the media of the objects whose materials ask for single scattering: one for each index of refraction.
pub(crate) fn media(state: &mut State, objects: &[Object], units: Units) {
    state.data.scattering_media.clear();
    for (number, object) in objects.iter().enumerate() {
        state.objects[number].scatters_once = object.material.single_scattering;
        if object.material.single_scattering {
            state.data.scattering_media.extend(of_material(&object.material, number as u32, units));
        }
    }
}

fn of_material(material: &Material, object: u32, units: Units) -> Vec<ScatteringMedium> {
    let channel = |c: usize| {
        let scattering = material.sigma_s_prime[c] / (1.0 - material.g[c]);
        let extinction = scattering + material.sigma_a[c];
        let inside = (extinction / units.length).min(DENSEST);
        (inside * (scattering / extinction), inside)
    };
    let mut media: Vec<ScatteringMedium> = Vec::new();
    for c in 0..3 {
        let (scattering, extinction) = channel(c);
        let (eta, reach) = (material.eta[c] as f32, (-FAINTEST.ln() / extinction).min(1e6) as f32);
        let known = media.iter().position(|medium| medium.eta.to_bits() == eta.to_bits());
        let index = known.unwrap_or_else(|| {
            media.push(ScatteringMedium { object, eta, ..ScatteringMedium::default() });
            media.len() - 1
        });
        let medium = &mut media[index];
        medium.reach = medium.reach.max(reach);
        medium.sigma_s[c] = scattering as f32;
        medium.sigma_t[c] = extinction as f32;
        medium.g[c] = material.g[c] as f32;
    }
    media
}
