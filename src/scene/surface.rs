//! The surface of a material: transmission of light that leaves, and reflection.

use super::file::MaterialFile;
use super::range::{self, Checked};
use crate::error::Input;
use serde::Deserialize;

/// Settings of a surface; the defaults are as published.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// Whether light that leaves is divided by 1 - F_ext, so that all of it leaves: the dipole's boundary term already
    /// accounts for internal reflection.
    pub normalize_exit: bool,
    /// The reflection, scaled by the boundary's Fresnel reflectance.
    pub reflection: Reflection,
}

/// How light is reflected at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Reflection {
    /// No reflection, as published.
    #[default]
    None,
    /// A lobe about the mirror direction: the cosine to the power of `shininess`, a whole number from 1 to 1000.
    Phong {
        /// The exponent.
        shininess: u32,
    },
    /// GGX microfacets (Walter et al. 2007).
    Ggx {
        /// alpha, 0.001 to 1.
        roughness: f64,
    },
}

/// `reflection` of a material.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ReflectionKind {
    #[default]
    None,
    Phong,
    Ggx,
}

impl Surface {
    /// Checks a material's surface keys, whose full names `key` gives.
    pub(super) fn check(file: &MaterialFile, key: impl Fn(&str) -> String) -> Checked<Self> {
        let others = [("roughness", file.roughness.is_some(), "ggx"), ("shininess", file.shininess.is_some(), "phong")];
        let kind = match file.reflection {
            ReflectionKind::None => "none",
            ReflectionKind::Phong => "phong",
            ReflectionKind::Ggx => "ggx",
        };
        if let Some((name, _, needed)) = others.into_iter().find(|(_, given, needed)| *given && *needed != kind) {
            let fault = Input::new("the material's reflection has no such key").key(key(name));
            return Err(fault.found(format!("reflection = \"{kind}\"")).expected(format!("reflection = \"{needed}\"")));
        }
        let reflection = match file.reflection {
            ReflectionKind::None => Reflection::None,
            ReflectionKind::Phong => {
                let value = file.shininess.unwrap_or(50);
                let shininess = u32::try_from(value).ok().filter(|n| (1..=1000).contains(n)).ok_or_else(|| {
                    let fault = Input::new("out of range").key(key("shininess")).found(value);
                    fault.expected("a whole number from 1 to 1000")
                })?;
                Reflection::Phong { shininess }
            }
            ReflectionKind::Ggx => {
                let accept = |x| (0.001..=1.0).contains(&x);
                let value = file.roughness.unwrap_or(0.2);
                Reflection::Ggx { roughness: range::number(&key("roughness"), value, accept, "0.001 to 1")? }
            }
        };
        Ok(Self { normalize_exit: file.normalize_exit, reflection })
    }
}
