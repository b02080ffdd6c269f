//! The scene file as serde deserializes it, and the check that turns it into a [`Draft`]: a scene without its meshes.

use super::camera::{Framing, Tone};
use super::layers::LayersFile;
use super::light::{Light, LightFile};
use super::material::Fresnel;
use super::object::{self, ObjectFile};
use super::play::Play;
use super::range::Checked;
use super::surface::ReflectionKind;
use super::texture::{Side, Wraps};
use super::transport::Transport;
use super::vector::{Background, Exposure, Rgb, Vector};
use serde::Deserialize;
use toml::{Table, Value};

/// A whole scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    #[serde(default)]
    unit: Unit,
    animation: Option<String>,
    fps: Option<f64>,
    #[serde(default)]
    camera: CameraFile,
    #[serde(default)]
    light: Vec<LightFile>,
    #[serde(default)]
    object: Vec<ObjectFile>,
    #[serde(default)]
    transport: Transport,
}

/// The length of one scene unit.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Unit {
    Um,
    #[default]
    Mm,
    Cm,
    M,
}

/// `[camera]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CameraFile {
    pub position: Option<Vector>,
    pub target: Option<Vector>,
    pub up: Option<Vector>,
    pub fov: Option<f64>,
    pub aperture: Option<f64>,
    pub focus: Option<f64>,
    pub size: Option<Vec<i64>>,
    pub samples: Option<u32>,
    pub exposure: Option<Exposure>,
    pub tone: Tone,
    pub background: Background,
}

/// `material` of an object.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct MaterialFile {
    pub preset: Option<String>,
    pub scale: Option<f64>,
    pub sigma_s_prime: Option<Rgb>,
    pub sigma_a: Option<Rgb>,
    pub eta: Option<Rgb>,
    pub g: Option<Rgb>,
    pub fresnel: Fresnel,
    pub two_sided: bool,
    pub single_scattering: bool,
    pub opaque: bool,
    pub albedo: Option<Rgb>,
    pub normalize_exit: bool,
    pub reflection: ReflectionKind,
    pub roughness: Option<f64>,
    pub second_roughness: Option<f64>,
    pub second_share: Option<f64>,
    pub shininess: Option<i64>,
    pub sigma_0: Option<Rgb>,
    pub sigma_0_texture: Option<String>,
    pub curvature_radius: Option<f64>,
    pub texture: Option<String>,
    pub texture_on: Option<Side>,
    pub texture_wrap: Option<Wraps>,
    pub layers: Option<LayersFile>,
}

/// A validated scene without its meshes.
#[derive(Debug)]
pub(super) struct Draft {
    /// Millimetres per scene unit.
    pub unit_mm: f64,
    /// The name of the animation to play.
    pub animation: Option<String>,
    /// Frames per second of animation and films.
    pub fps: f64,
    /// The camera, not fitted to the objects yet.
    pub framing: Framing,
    /// The lights, in the file's order.
    pub lights: Vec<Light>,
    /// The objects.
    pub objects: Vec<object::Draft>,
    /// Light transport.
    pub transport: Transport,
    /// The first and the last frame of the keyframes.
    pub frames: Option<[f64; 2]>,
}

impl SceneFile {
    /// Checks every value; `table` is the TOML that this was read from.
    pub fn check(&self, table: &Table) -> Checked<Draft> {
        let none = Table::new();
        let transport = table.get("transport").and_then(Value::as_table).unwrap_or(&none);
        let unit_mm = match self.unit {
            Unit::Um => 1e-3,
            Unit::Mm => 1.0,
            Unit::Cm => 10.0,
            Unit::M => 1e3,
        };
        let framing = Framing::check(&self.camera)?;
        let lights = self.light.iter().enumerate().map(|(index, light)| Light::check(light, index));
        let lights = lights.collect::<Checked<Vec<Light>>>()?;
        Light::check_all(&lights)?;
        framing.check_background(&lights)?;
        Ok(Draft {
            unit_mm,
            animation: self.animation.clone(),
            fps: Play::fps(self.fps)?,
            framing,
            lights,
            objects: object::check_all(&self.object, unit_mm)?,
            transport: self.transport.check(transport)?,
            frames: None,
        })
    }
}
