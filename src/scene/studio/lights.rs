//! The lights of the studio, its backdrop and its table.

use super::super::Files;
use super::pose::Pose;
use super::{mean, value};
use crate::scene::range::Checked;
use glam::DVec3;
use toml::{Table, Value};

/// The surroundings of the object.
#[derive(Debug)]
pub(super) enum Backdrop {
    /// The grey backdrop, which is the fill light too.
    Grey,
    /// An image, and a factor that makes it as bright as the studio.
    Image(String, f64),
    /// The mesh file has lights of its own, which stay.
    Own,
}

/// Side of a softbox, in radii of the object.
const SOFTBOX: f64 = 1.4;

/// Mean radiance that an image of the surroundings is brought to.
const AROUND: f64 = 0.25;

impl Backdrop {
    /// The image, if there is one, or else the file's `own` lights, or else the studio's grey.
    pub fn of(image: Option<&str>, own: bool, files: &Files) -> Checked<Self> {
        Ok(match image {
            Some(image) => Self::Image(image.to_owned(), AROUND / mean(image, files)?.max(1e-12)),
            None if own => Self::Own,
            None => Self::Grey,
        })
    }

    /// Whether the lights are those of the mesh file.
    pub fn is_own(&self) -> bool {
        matches!(self, Self::Own)
    }

    /// What the camera, with this exposure, shows behind the object.
    pub fn background(&self, exposure: f64) -> Value {
        match self {
            Self::Own => Value::Array(vec![Value::Float(0.05 / exposure); 3]),
            _ => "environment".into(),
        }
    }

    /// The lights, for a camera with this exposure; none if the file's stay. The light behind a `thin` object is
    /// weaker, since the object hardly dims it.
    pub fn lights(&self, pose: &Pose, [ground, thin]: [bool; 2], exposure: f64) -> Option<Vec<Value>> {
        // Over a table the light behind shines flatter and weaker, since it dazzles in front of the object.
        let behind = if ground { DVec3::new(1.9, 0.9, -3.2) } else { DVec3::new(1.7, 2.0, -2.4) };
        let strength = if ground { 150.0 } else { 230.0 } * if thin { 0.25 } else { 1.0 };
        let front = if ground { 1.6 } else { 0.8 };
        // The table shows each grain of a shadow.
        let samples = if ground { 6 } else { 3 };
        let key = area(pose, DVec3::new(-2.2, 2.8, 2.4), samples, [9.0, 8.6, 8.0].map(|c| c * front / exposure));
        let back = |share: f64| area(pose, behind, samples, [1.0, 0.9, 0.78].map(|c| c * strength * share / exposure));
        let around = |image: &str, intensity: f64, rotation: f64| {
            let mut light = Table::new();
            light.insert("type".into(), "environment".into());
            light.insert("image".into(), image.into());
            light.insert("intensity".into(), Value::Float(intensity / exposure));
            light.insert("rotation".into(), Value::Float(rotation.rem_euclid(360.0)));
            if thin {
                // The inside of a pot would be as bright as its outside.
                light.insert("occlusion".into(), Value::Integer(64));
            }
            Value::Table(light)
        };
        match self {
            Self::Own => None,
            Self::Grey => Some(vec![around("builtin:studio", 1.0, pose.yaw), key, back(1.0)]),
            Self::Image(image, factor) => Some(vec![around(image, *factor, 0.0), back(0.6)]),
        }
    }

    /// The lights in a few words.
    pub fn words(&self) -> &'static str {
        match self {
            Self::Grey => "key, fill and back light",
            Self::Image(..) => "the image's light and one behind",
            Self::Own => "the file's lights",
        }
    }
}

/// A square softbox at a place of the studio, that faces the object, with so many samples along a side.
fn area(pose: &Pose, place: DVec3, samples: i64, radiance: [f64; 3]) -> Value {
    let toward = -place.normalize();
    let across = DVec3::Y.cross(toward).normalize();
    let [u, v] = [across, toward.cross(across)].map(|edge| pose.direction(edge) * SOFTBOX * pose.radius);
    let mut light = Table::new();
    light.insert("type".into(), "area".into());
    light.insert("position".into(), value(pose.place_at(place)));
    light.insert("edge_u".into(), value(u));
    light.insert("edge_v".into(), value(v));
    light.insert("radiance".into(), Value::Array(radiance.map(Value::Float).to_vec()));
    light.insert("samples".into(), Value::Integer(samples));
    Value::Table(light)
}

/// A dark table under the object.
pub(super) fn ground(pose: &Pose) -> Value {
    let mut material = Table::new();
    material.insert("opaque".into(), Value::Boolean(true));
    material.insert("albedo".into(), Value::Float(0.12));
    let mut object = Table::new();
    object.insert("shape".into(), "plane".into());
    object.insert("detail".into(), Value::Integer(1));
    object.insert("size".into(), Value::Float(60.0 * pose.radius));
    object.insert("position".into(), value(DVec3::new(pose.middle.x, pose.floor, pose.middle.z)));
    object.insert("material".into(), Value::Table(material));
    Value::Table(object)
}
