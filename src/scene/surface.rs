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
    /// GGX microfacets (Walter et al. 2007), in two lobes whose sum of shares is 1.
    Ggx {
        /// alpha of the first lobe, 0.001 to 1.
        roughness: f64,
        /// alpha of the second lobe, likewise.
        second_roughness: f64,
        /// Share of the second lobe, 0 to 1; 0 where there is one.
        second_share: f64,
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
        let others = [
            ("roughness", file.roughness.is_some(), "ggx"),
            ("second_roughness", file.second_roughness.is_some(), "ggx"),
            ("second_share", file.second_share.is_some(), "ggx"),
            ("shininess", file.shininess.is_some(), "phong"),
        ];
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
            ReflectionKind::Ggx => Self::facets(file, key)?,
        };
        Ok(Self { normalize_exit: file.normalize_exit, reflection })
    }

    /// Checks the keys of microfacets.
    fn facets(file: &MaterialFile, key: impl Fn(&str) -> String) -> Checked<Reflection> {
        let alpha =
            |name: &str, value: f64| range::number(&key(name), value, |x| (0.001..=1.0).contains(&x), "0.001 to 1");
        let roughness = alpha("roughness", file.roughness.unwrap_or(0.2))?;
        let Some(second) = file.second_roughness else {
            return match file.second_share {
                None => Ok(Reflection::Ggx { roughness, second_roughness: roughness, second_share: 0.0 }),
                Some(share) => {
                    let fault = Input::new("the share of a lobe that is missing").key(key("second_share")).found(share);
                    Err(fault.expected("second_roughness beside it"))
                }
            };
        };
        let share = file.second_share.unwrap_or(0.5);
        Ok(Reflection::Ggx {
            roughness,
            second_roughness: alpha("second_roughness", second)?,
            second_share: range::number(&key("second_share"), share, |x| (0.0..=1.0).contains(&x), "0 to 1")?,
        })
    }
}
