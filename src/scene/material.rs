//! Materials: scattering and absorption per scene unit, index of refraction, Fresnel formula, surface, textures,
//! layers.

use super::file::MaterialFile;
use super::layers::Layers;
use super::preset::Preset;
use super::range::{self, Checked};
use super::surface::{Reflection, Surface};
use super::texture::{Side, Texture};
use super::vector::Rgb;
use crate::error::Input;
use serde::Deserialize;

/// Default relative index of refraction of a material without a preset.
pub const ETA: f64 = 1.3;

/// The largest index that the papers' polynomial is used for: up to it F_dr stays below 1, where the boundary term
/// would be infinite.
const PAPER_ETA: f64 = 3.8;

/// Which formula gives the diffuse Fresnel reflectance F_dr of the dipole's boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Fresnel {
    /// The closed form of the integral.
    #[default]
    Exact,
    /// The polynomial printed in the papers.
    Paper,
}

/// A validated homogeneous material, translucent or opaque.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The preset's name, `NAME, modified` when keys override it, `custom` without a preset, or `opaque`.
    pub name: String,
    /// Reduced scattering coefficient per scene unit, r g b, at least 0.
    pub sigma_s_prime: [f64; 3],
    /// Absorption coefficient per scene unit, r g b, at least 0; the sum with scattering is above 0.
    pub sigma_a: [f64; 3],
    /// Relative index of refraction, inside over outside, r g b, 0.5 to 5.
    pub eta: [f64; 3],
    /// Mean cosine of the scattering angle, r g b, -0.95 to 0.95; the random walk and single scattering use it.
    pub g: [f64; 3],
    /// Diffuse albedo of an opaque object, r g b, 0 to 1; none if light enters.
    pub opaque: Option<[f64; 3]>,
    /// Which formula gives the diffuse Fresnel reflectance.
    pub fresnel: Fresnel,
    /// Whether both sides of a face receive light, each by its own cosine; lights may then be inside the medium.
    pub two_sided: bool,
    /// Whether pictures show the light that the medium scatters once, beside the diffused light.
    pub single_scattering: bool,
    /// Exit and reflection of light at the surface.
    pub surface: Surface,
    /// sigma_0 of the CDRF in scene units, r g b, at least 0; none if it follows from the coefficients.
    pub sigma_0: Option<[f64; 3]>,
    /// Radius within which curvature is smoothed, scene units, at least 0; none if it follows from sigma_0.
    pub curvature_radius: Option<f64>,
    /// Factor d over the surface, if not 1 everywhere: sigma_0 is multiplied by d^2.
    pub sigma_0_texture: Option<Texture>,
    /// Factor on light where it enters or leaves, if not 1 everywhere.
    pub texture: Option<Texture>,
    /// Layers beneath the surface, if any, in which light scatters once.
    pub layers: Option<Layers>,
}

impl Material {
    /// Checks the `material` under `key`, in scene units of `unit_mm` millimetres.
    pub(super) fn check(file: &MaterialFile, key: &str, unit_mm: f64) -> Checked<Self> {
        let key = |name: &str| format!("{key}.{name}");
        let layers = |scale: f64| match &file.layers {
            Some(layers) => Layers::check(layers, &key("layers"), scale * unit_mm).map(Some),
            None => Ok(None),
        };
        let scale = range::number(&key("scale"), file.scale.unwrap_or(1.0), |x| x > 0.0, "above 0");
        let bare = file.preset.is_none() && file.sigma_s_prime.is_none() && file.sigma_a.is_none();
        if file.opaque || (file.layers.is_some() && bare) {
            let made = Self { layers: layers(scale?)?, ..Self::opaque(file, &key)? };
            return made.check_wraps(key).map(|()| made);
        }
        if file.albedo.is_some() {
            let fault = Input::new("only an opaque material has an albedo").key(key("albedo"));
            return Err(fault.found("opaque = false").expected("opaque = true, or scattering and absorption"));
        }

        let preset = file.preset.as_deref().map(|name| Preset::find(name, &key("preset"))).transpose()?;
        let [scattering, absorption, eta, g] = Self::optics(file, preset, &key)?;
        let scale = scale?;
        let [sigma_s_prime, sigma_a] = Self::per_unit([scattering, absorption], [scale, unit_mm], &key)?;
        let modified = file.sigma_s_prime.is_some() || file.sigma_a.is_some() || file.eta.is_some();
        let name = match preset {
            None => "custom".to_owned(),
            Some(preset) if modified => format!("{}, modified", preset.name),
            Some(preset) => preset.name.to_owned(),
        };
        let (fresnel, two_sided) = (file.fresnel, file.two_sided);
        let (surface, texture, layers) = (Surface::check(file, key)?, Texture::check(file, key)?, layers(scale)?);
        let sigma_0 = match file.sigma_0 {
            None => None,
            Some(Rgb(values)) => {
                let values = values.map(|x| x / (scale * unit_mm));
                Some(range::channels(&key("sigma_0"), values, |x| x >= 0.0, "numbers of at least 0, mm")?)
            }
        };
        let radius = |mm: f64| {
            let value = mm / (scale * unit_mm);
            range::number(&key("curvature_radius"), value, |x| x >= 0.0, "at least 0, mm")
        };
        let curvature_radius = file.curvature_radius.map(radius).transpose()?;
        let made = Self {
            name,
            sigma_s_prime,
            sigma_a,
            eta,
            g,
            opaque: None,
            fresnel,
            two_sided,
            single_scattering: file.single_scattering,
            surface,
            sigma_0,
            curvature_radius,
            sigma_0_texture: Texture::sigma_0(file, key)?,
            texture,
            layers,
        };
        made.check_wraps(key)?;
        made.check_single(key).map(|()| made)
    }

    /// Scattering and absorption per mm, index of refraction and mean cosine: the preset's and its overrides.
    fn optics(file: &MaterialFile, preset: Option<&Preset>, key: &impl Fn(&str) -> String) -> Checked<[[f64; 3]; 4]> {
        let pick = |name: &str, own: Option<Rgb>, of_preset: Option<[f64; 3]>| {
            own.map(|rgb| rgb.0).or(of_preset).ok_or_else(|| {
                let what = "missing: a material needs it, or a preset";
                Input::new(what).key(key(name)).expected("a number or [r, g, b], per mm")
            })
        };
        let scattering = pick("sigma_s_prime", file.sigma_s_prime, preset.map(|p| p.sigma_s_prime))?;
        let absorption = pick("sigma_a", file.sigma_a, preset.map(|p| p.sigma_a))?;
        let eta = file.eta.map_or([preset.map_or(ETA, |p| p.eta); 3], |rgb| rgb.0);

        let zero_up = "numbers of at least 0, per mm";
        range::channels(&key("sigma_s_prime"), scattering, |x| x >= 0.0, zero_up)?;
        range::channels(&key("sigma_a"), absorption, |x| x >= 0.0, zero_up)?;
        range::channels(&key("eta"), eta, |x| (0.5..=5.0).contains(&x), "numbers from 0.5 to 5")?;
        if file.fresnel == Fresnel::Paper {
            let expected =
                format!("numbers of at most {PAPER_ETA}, or fresnel = \"exact\": the polynomial F_dr passes 1");
            range::channels(&key("eta"), eta, |x| x <= PAPER_ETA, &expected)?;
        }
        let g = file.g.map_or([0.0; 3], |rgb| rgb.0);
        range::channels(&key("g"), g, |x| x.abs() <= 0.95, "numbers from -0.95 to 0.95")?;
        Ok([scattering, absorption, eta, g])
    }

    /// Coefficients in scene units, of a scale and millimetres: one may overflow, or a whole channel vanish.
    fn per_unit(
        [scattering, absorption]: [[f64; 3]; 2],
        [scale, unit_mm]: [f64; 2],
        key: &impl Fn(&str) -> String,
    ) -> Checked<[[f64; 3]; 2]> {
        let per_unit = |name: &str, values: [f64; 3]| {
            let values = values.map(|x| x * scale * unit_mm);
            range::channels(&key(name), values, |_| true, "a finite number after unit and scale")
        };
        let sigma_s_prime = per_unit("sigma_s_prime", scattering)?;
        let sigma_a = per_unit("sigma_a", absorption)?;
        if let Some(channel) = (0..3).find(|&c| !(sigma_s_prime[c] + sigma_a[c]).is_finite()) {
            let found = format!("{:e} and {:e}", sigma_s_prime[channel], sigma_a[channel]);
            let expected = "sigma_s_prime + sigma_a a finite number in every channel";
            return Err(Input::new("out of range").key(key("sigma_s_prime")).found(found).expected(expected));
        }
        if let Some(channel) = (0..3).find(|&c| sigma_s_prime[c] + sigma_a[c] < f64::MIN_POSITIVE) {
            let what = "a channel neither scatters nor absorbs";
            let found = format!("0 for both in channel {}", ["r", "g", "b"][channel]);
            let expected = "sigma_s_prime + sigma_a above 0 in every channel";
            return Err(Input::new(what).key(key("sigma_s_prime")).found(found).expected(expected));
        }
        Ok([sigma_s_prime, sigma_a])
    }

    /// A material that light does not enter: a diffuse surface. Its index defaults to 1, or to 1.5 if it reflects.
    fn opaque(file: &MaterialFile, key: &impl Fn(&str) -> String) -> Checked<Self> {
        let others = [
            ("preset", file.preset.is_some()),
            ("sigma_s_prime", file.sigma_s_prime.is_some()),
            ("sigma_a", file.sigma_a.is_some()),
            ("g", file.g.is_some()),
            ("two_sided", file.two_sided),
            ("single_scattering", file.single_scattering),
            ("normalize_exit", file.normalize_exit),
            ("sigma_0", file.sigma_0.is_some()),
            ("sigma_0_texture", file.sigma_0_texture.is_some()),
            ("curvature_radius", file.curvature_radius.is_some()),
        ];
        if let Some((name, _)) = others.into_iter().find(|(_, given)| *given) {
            let (what, found) = match file.opaque {
                true => ("an opaque material has no such key", "opaque = true"),
                false => {
                    ("a material of layers alone has no such key", "no sigma_s_prime and sigma_a beside the layers")
                }
            };
            return Err(Input::new(what)
                .key(key(name))
                .found(found)
                .expected("albedo, eta, reflection, roughness, second_roughness, second_share, shininess, texture"));
        }
        // With layers alone, the surface itself has albedo 0 by default.
        let usual = if file.layers.is_some() && !file.opaque { 0.0 } else { 0.5 };
        let albedo = file.albedo.map_or([usual; 3], |rgb| rgb.0);
        range::channels(&key("albedo"), albedo, |x| (0.0..=1.0).contains(&x), "numbers from 0 to 1")?;
        let (surface, texture) = (Surface::check(file, key)?, Texture::check(file, key)?);
        let eta = file.eta.map_or([if surface.reflection == Reflection::None { 1.0 } else { 1.5 }; 3], |rgb| rgb.0);
        range::channels(&key("eta"), eta, |x| (1.0..=5.0).contains(&x), "numbers from 1 to 5")?;
        Ok(Self {
            name: "opaque".to_owned(),
            sigma_s_prime: [0.0; 3],
            sigma_a: [0.0; 3],
            eta,
            g: [0.0; 3],
            opaque: Some(albedo),
            fresnel: file.fresnel,
            two_sided: false,
            single_scattering: false,
            surface,
            sigma_0: None,
            curvature_radius: None,
            sigma_0_texture: None,
            texture,
            layers: None,
        })
    }

    /// The key of what needs texture coordinates, if anything does.
    pub(super) fn textured(&self) -> Option<&'static str> {
        let keys = [
            (self.texture.is_some(), "texture"),
            (self.layers.as_ref().is_some_and(|layers| layers.map.mapped), "layers.maps"),
            (self.sigma_0_texture.is_some(), "sigma_0_texture"),
        ];
        keys.into_iter().find(|(needs, _)| *needs).map(|(_, key)| key)
    }

    /// Fails if `single_scattering` is set beside a key with which it has no meaning.
    fn check_single(&self, key: impl Fn(&str) -> String) -> Checked<()> {
        let entry = self.texture.as_ref().is_some_and(|texture| texture.side != Side::Exit);
        let (other, what, expected) = match () {
            () if !self.single_scattering => return Ok(()),
            () if self.layers.is_some() => {
                ("layers", "light scatters once in the layers, and in no other medium", "no layers")
            }
            () if self.two_sided => ("two_sided", "light is scattered once on the inner side only", "false"),
            () if entry => {
                ("texture_on", "a texture changes light that is scattered once only where it leaves", "\"exit\"")
            }
            () => return Ok(()),
        };
        let fault = Input::new(what).key(key(other)).found("single_scattering = true beside it");
        Err(fault.expected(format!("{expected}, or single_scattering = false")))
    }

    /// Depth maps and textures share the texture coordinates of the mesh, reduced by whole periods: they must wrap
    /// alike.
    fn check_wraps(&self, key: impl Fn(&str) -> String) -> Checked<()> {
        match (&self.layers, self.texture.as_ref().or(self.sigma_0_texture.as_ref())) {
            (Some(layers), Some(texture)) if layers.map.mapped && texture.wrap != [layers.map.wrap; 2] => {
                let fault = Input::new("texture and maps go on beyond their edges in different ways");
                Err(fault.key(key("layers.wrap")).expected("the same as texture_wrap"))
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
