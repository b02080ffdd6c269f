//! The scene file as serde deserializes it, and the check that turns it into a [`Draft`]: a scene without its meshes.

use super::camera::{self, Framing, Tone};
use super::layers::LayersFile;
use super::light::{Light, LightFile};
use super::local::{self, Cdrf, Kappa};
use super::material::Fresnel;
use super::object::{self, ObjectFile};
use super::play::Play;
use super::range::Checked;
use super::surface::ReflectionKind;
use super::texture::{Side, Wrap};
use super::transport::{self, ClusterForm, Distance, Hierarchy, Near, Oracle, Receivers, Scheme, Transport};
use super::vector::{Background, Rgb, Vector};
use serde::Deserialize;

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
    transport: TransportFile,
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
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CameraFile {
    pub position: Option<Vector>,
    pub target: Option<Vector>,
    pub up: Vector,
    pub fov: f64,
    pub size: Vec<i64>,
    pub samples: u32,
    pub exposure: f64,
    pub tone: Tone,
    pub background: Background,
}

impl Default for CameraFile {
    fn default() -> Self {
        Self {
            position: None,
            target: None,
            up: Vector([0.0, 1.0, 0.0]),
            fov: camera::FOV,
            size: camera::SIZE.map(i64::from).to_vec(),
            samples: 1,
            exposure: 1.0,
            tone: Tone::Clip,
            background: Background::Color([0.0; 3]),
        }
    }
}

/// `material` of an object.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct MaterialFile {
    pub preset: Option<String>,
    pub scale: f64,
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
    pub shininess: Option<i64>,
    pub sigma_0: Option<Rgb>,
    pub sigma_0_texture: Option<String>,
    pub curvature_radius: Option<f64>,
    pub texture: Option<String>,
    pub texture_on: Option<Side>,
    pub texture_wrap: Option<Wrap>,
    pub layers: Option<LayersFile>,
}

impl Default for MaterialFile {
    fn default() -> Self {
        Self {
            preset: None,
            scale: 1.0,
            sigma_s_prime: None,
            sigma_a: None,
            eta: None,
            g: None,
            fresnel: Fresnel::default(),
            two_sided: false,
            single_scattering: false,
            opaque: false,
            albedo: None,
            normalize_exit: false,
            reflection: ReflectionKind::None,
            roughness: None,
            shininess: None,
            sigma_0: None,
            sigma_0_texture: None,
            curvature_radius: None,
            texture: None,
            texture_on: None,
            texture_wrap: None,
            layers: None,
        }
    }
}

/// `[transport]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct TransportFile {
    pub scheme: Option<Scheme>,
    pub oracle: Option<Oracle>,
    pub tolerance: f64,
    pub order: u32,
    pub hierarchy: Option<Hierarchy>,
    pub levels: Option<i64>,
    pub receivers: Receivers,
    pub subdivide: u32,
    pub distance: Distance,
    pub near: Near,
    pub cluster: Option<ClusterForm>,
    pub receiver_angle: Option<f64>,
    pub emitter_angle: Option<f64>,
    pub planarity: Option<f64>,
    pub form_factor_tolerance: f64,
    pub octree_angle: f64,
    pub walk_error: f64,
    pub walks: Option<i64>,
    pub steps: Option<i64>,
    pub budget: Option<i64>,
    pub cdrf: Cdrf,
    pub cdrf_table: u32,
    pub curvature: Kappa,
    pub unwrap: bool,
    pub blur_texture: u32,
}

impl Default for TransportFile {
    fn default() -> Self {
        Self {
            scheme: None,
            oracle: None,
            tolerance: transport::TOLERANCE,
            order: 2,
            hierarchy: None,
            levels: None,
            receivers: Receivers::default(),
            subdivide: 0,
            distance: Distance::default(),
            near: Near::default(),
            cluster: None,
            receiver_angle: None,
            emitter_angle: None,
            planarity: None,
            form_factor_tolerance: transport::FORM_FACTOR_TOLERANCE,
            octree_angle: transport::OCTREE_ANGLE,
            walk_error: transport::WALK_ERROR,
            walks: None,
            steps: None,
            budget: None,
            cdrf: Cdrf::default(),
            cdrf_table: local::CDRF_TABLE,
            curvature: Kappa::default(),
            unwrap: false,
            blur_texture: local::BLUR_TEXTURE,
        }
    }
}

/// A validated scene without its meshes.
#[derive(Debug)]
pub(super) struct Draft {
    /// Millimetres per scene unit.
    pub unit_mm: f64,
    /// The animation to play, and its frames per second.
    pub animation: Option<(String, f64)>,
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
    /// Checks every value.
    pub fn check(&self) -> Checked<Draft> {
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
            animation: Play::check(self.animation.as_ref(), self.fps)?,
            framing,
            lights,
            objects: object::check_all(&self.object, unit_mm)?,
            transport: Transport::check(&self.transport)?,
            frames: None,
        })
    }
}
