//! `[[light]]` as serde deserializes it.

use super::super::vector::{Rgb, Vector};
use serde::Deserialize;

macro_rules! keys {
    ($($key:ident: $kind:ty,)*) => {
        /// `[[light]]`: the keys of every kind; [`Light::check`](super::Light::check) checks which belong to a kind.
        #[derive(Debug, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(in crate::scene) struct LightFile {
            #[serde(rename = "type")]
            pub kind: LightKind,
            $(pub $key: Option<$kind>,)*
        }

        impl LightFile {
            /// The names of the keys that are given, except `type`.
            pub fn given(&self) -> Vec<&'static str> {
                let all = [$((stringify!($key), self.$key.is_some()),)*];
                all.into_iter().filter(|(_, there)| *there).map(|(name, _)| name).collect()
            }
        }
    };
}

keys! {
    direction: Vector,
    target: Vector,
    irradiance: Rgb,
    position: Vector,
    intensity: Rgb,
    inner: f64,
    outer: f64,
    edge_u: Vector,
    edge_v: Vector,
    radiance: Rgb,
    two_sided: bool,
    samples: i64,
    image: String,
    rotation: f64,
    occlusion: i64,
    sun: bool,
    shadows: bool,
}

/// `type` of a light.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::scene) enum LightKind {
    Directional,
    Point,
    Spot,
    Area,
    Environment,
}
