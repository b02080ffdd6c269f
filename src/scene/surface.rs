//! What a material's surface does with light: what leaves, and what it reflects.

use super::file::MaterialFile;
use super::range::{self, Checked};
use crate::error::Input;
use serde::Deserialize;

/// Switches of a surface; by default as published.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// Whether light that leaves is divided by 1 - F_ext, so that all of it does: the dipole's boundary term already
    /// has what is reflected back inside.
    pub normalize_exit: bool,
    /// What is reflected, times the boundary's Fresnel reflectance.
    pub reflection: Reflection,
}

/// How light is reflected at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Reflection {
    /// Not at all, as published.
    #[default]
    None,
    /// A lobe about the mirror direction, the cosine to the power of `shininess`, a whole number from 1 to 1000.
    Phong {
        /// The exponent.
        shininess: u32,
    },
    /// Microfacets (Walter et al. 2007).
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
    /// Checks a material's keys, each called by `key`.
    pub(super) fn check(file: &MaterialFile, key: impl Fn(&str) -> String) -> Checked<Self> {
        let others = [("roughness", file.roughness.is_some(), "ggx"), ("shininess", file.shininess.is_some(), "phong")];
        let kind = match file.reflection {
            ReflectionKind::None => "none",
            ReflectionKind::Phong => "phong",
            ReflectionKind::Ggx => "ggx",
        };
        if let Some((name, _, of)) = others.into_iter().find(|(_, given, of)| *given && *of != kind) {
            let fault = Input::new("the material's reflection has no such key").key(key(name));
            return Err(fault.found(format!("reflection = \"{kind}\"")).expected(format!("reflection = \"{of}\"")));
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
