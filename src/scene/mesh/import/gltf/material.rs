//! Materials of glTF as materials of a scene.

use super::document::{Document, extension, number, numbers};
use super::{Checked, Parts, Tint, Tree};
use gltf::json::material::{AlphaMode, Material};
use gltf::json::validation::Checked::Valid;
use toml::{Table, Value};

/// Scattering in a volume, per metre.
pub(super) struct Medium {
    sigma_s_prime: [f64; 3],
    sigma_a: [f64; 3],
    g: f64,
}

impl Medium {
    /// The medium that `KHR_materials_volume` gives together with what scatters in it.
    ///
    /// The attenuation sigma_t is -ln(colour) / distance. `KHR_materials_volume_scatter` gives the albedo rho of
    /// multiple scattering, from which that of single scattering follows by the fit of Kulla and Conty 2017
    /// ("Revisiting Physically Based Shading at Imageworks"), solved for s:
    /// rho = (1 - s) (1 - 0.139 s) / (1 + 1.17 s), s^2 = (1 - a) / (1 - g a). Without that extension, the colour of
    /// `KHR_materials_diffuse_transmission` stands for rho.
    pub fn of(material: &Material) -> Option<Self> {
        let volume = extension!(material, "KHR_materials_volume");
        let distance = number(volume, "attenuationDistance", f64::INFINITY);
        let (scatter, diffuse) = (
            extension!(material, "KHR_materials_volume_scatter"),
            extension!(material, "KHR_materials_diffuse_transmission"),
        );
        if !(distance.is_finite() && distance > 0.0) || scatter.is_none() && diffuse.is_none() {
            return None;
        }
        let color = numbers(volume, "attenuationColor", [1.0; 3]);
        let of_diffuse = numbers(diffuse, "diffuseTransmissionColorFactor", [1.0; 3]);
        let albedo = match scatter {
            // A draft of the extension has the second name.
            Some(_) => numbers(scatter, "multiscatterColor", numbers(scatter, "multiscatterColorFactor", [0.0; 3])),
            None => of_diffuse,
        };
        let g = number(scatter, "scatterAnisotropy", 0.0).clamp(-0.95, 0.95);
        // Where nothing is attenuated the medium would not be there.
        let sigma_t = color.map(|c| -c.clamp(1e-9, 1.0 - 1e-6).ln() / distance);
        let single = albedo.map(|rho| single_scattering(rho, g));
        Some(Self {
            sigma_s_prime: [0, 1, 2].map(|k| sigma_t[k] * single[k] * (1.0 - g)),
            sigma_a: [0, 1, 2].map(|k| sigma_t[k] * (1.0 - single[k])),
            g,
        })
    }
}

/// The albedo of single scattering of a medium with this albedo of multiple scattering and mean cosine.
fn single_scattering(rho: f64, g: f64) -> f64 {
    let rho = rho.clamp(0.0, 1.0);
    let b = 1.139 + 1.17 * rho;
    let s = (b - f64::max(b * b - 4.0 * 0.139 * (1.0 - rho), 0.0).sqrt()) / (2.0 * 0.139);
    let square = (s * s).clamp(0.0, 1.0);
    (1.0 - square) / (1.0 - g * square)
}

/// The name of a material in messages.
fn called(material: &Material) -> &str {
    material.name.as_deref().unwrap_or("without a name")
}

/// The material of a part in a scene; `around` is that of a mesh alone. What cannot be rendered is added to `notes`.
pub(super) fn of_part(
    document: &Document,
    tree: &Tree,
    parts: &Parts,
    around: &Table,
    notes: &mut Vec<String>,
) -> Checked<Table> {
    let mut made = around.clone();
    let material = parts.chosen[0].map(|index| &document.root.materials[index]);
    let list = |values: [f64; 3]| Value::Array(values.map(Value::Float).to_vec());
    let medium = material.and_then(Medium::of);
    if let Some(material) = material {
        let name = called(material);
        let roughness = f64::from(material.pbr_metallic_roughness.roughness_factor.0);
        made.remove("shininess");
        made.insert("reflection".into(), "ggx".into());
        made.insert("roughness".into(), (roughness * roughness).clamp(0.001, 1.0).into());
        let ior = number(extension!(material, "KHR_materials_ior"), "ior", 1.5);
        if medium.is_some() || extension!(material, "KHR_materials_ior").is_some() {
            made.insert("eta".into(), ior.clamp(1.0, 5.0).into());
        }
        let mut note = |words: &str| notes.push(format!("material {name}: {words}"));
        let clear = ["KHR_materials_transmission", "KHR_materials_volume"];
        if medium.is_none() && clear.iter().any(|name| extension!(material, *name).is_some()) {
            note(
                "a clear medium, without scattering, cannot be rendered; it gets the material that the mesh has otherwise",
            );
        } else if medium.is_none() && extension!(material, "KHR_materials_diffuse_transmission").is_some() {
            note("diffuse transmission without a volume is left out; it gets the material that the mesh has otherwise");
        }
        match material.alpha_mode {
            Valid(AlphaMode::Mask) => note("its alpha mask is left out: what it would cut away is shown"),
            Valid(AlphaMode::Blend) => note("its opacity is left out: it is shown in full"),
            _ => {}
        }
    }
    match medium {
        Some(medium) => {
            made.remove("preset");
            // Per mm.
            made.insert("sigma_s_prime".into(), list(medium.sigma_s_prime.map(|x| x / 1000.0)));
            made.insert("sigma_a".into(), list(medium.sigma_a.map(|x| x / 1000.0)));
            made.insert("g".into(), medium.g.into());
        }
        None => {
            let tint = Tint::of(document, tree, parts)?;
            if let (Some(material), Some(index)) = (material, parts.chosen[0])
                && let Some(words) = tint.left_out(document, tree, index)?
            {
                notes.push(format!("material {}: {words}", called(material)));
            }
            if tint.matters() {
                made.insert("texture".into(), "mesh".into());
                let words = match tint.wrap(document) {
                    [u, v] if u == v => u.into(),
                    both => Value::Array(both.map(Value::from).to_vec()),
                };
                made.insert("texture_wrap".into(), words);
            }
        }
    }
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedos_of_multiple_scattering_are_those_of_the_fit() {
        // The published closed form for g = 0.
        for rho in [0.0, 0.1, 0.572, 0.9, 0.999] {
            let s = 4.09712 + 4.20863 * rho - f64::sqrt(9.59217 + 41.6808 * rho + 17.7126 * rho * rho);
            assert!((single_scattering(rho, 0.0) - (1.0 - s * s)).abs() < 1e-4, "{rho}");
        }
        // The fit itself, at another g.
        let a = single_scattering(0.6, 0.5);
        let s = f64::sqrt((1.0 - a) / (1.0 - 0.5 * a));
        assert!(((1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s) - 0.6).abs() < 1e-9);
        assert_eq!(single_scattering(1.0, 0.3), 1.0);
    }
}
