//! The scene file: its tables and keys as serde sees them, and the check that turns them into a
//! [`Draft`], which is everything but the mesh itself.

use super::camera::{self, Framing, Tone};
use super::light::{Light, LightFile};
use super::material::{Fresnel, Material};
use super::mesh::Shape;
use super::range::{self, Checked};
use super::surface::ReflectionKind;
use super::texture::{Side, Wrap};
use super::transport::{self, Distance, Hierarchy, Near, Oracle, Scheme, Transport};
use super::vector::{Background, Rgb, Vector};
use crate::error::Input;
use serde::Deserialize;
use std::path::PathBuf;

/// A whole scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    #[serde(default)]
    unit: Unit,
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

/// `[[object]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    mesh: Option<PathBuf>,
    shape: Option<Shape>,
    detail: Option<i64>,
    size: Option<f64>,
    #[serde(default)]
    material: MaterialFile,
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
    pub fresnel: Fresnel,
    pub two_sided: bool,
    pub normalize_exit: bool,
    pub reflection: ReflectionKind,
    pub roughness: Option<f64>,
    pub shininess: Option<i64>,
    pub texture: Option<String>,
    pub texture_on: Option<Side>,
    pub texture_wrap: Option<Wrap>,
}

impl Default for MaterialFile {
    fn default() -> Self {
        Self {
            preset: None,
            scale: 1.0,
            sigma_s_prime: None,
            sigma_a: None,
            eta: None,
            fresnel: Fresnel::default(),
            two_sided: false,
            normalize_exit: false,
            reflection: ReflectionKind::None,
            roughness: None,
            shininess: None,
            texture: None,
            texture_on: None,
            texture_wrap: None,
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
    pub distance: Distance,
    pub near: Near,
    pub receiver_angle: Option<f64>,
    pub emitter_angle: Option<f64>,
    pub planarity: Option<f64>,
    pub form_factor_tolerance: f64,
    pub octree_angle: f64,
}

impl Default for TransportFile {
    fn default() -> Self {
        Self {
            scheme: None,
            oracle: None,
            tolerance: transport::TOLERANCE,
            order: 2,
            hierarchy: None,
            distance: Distance::default(),
            near: Near::default(),
            receiver_angle: None,
            emitter_angle: None,
            planarity: None,
            form_factor_tolerance: transport::FORM_FACTOR_TOLERANCE,
            octree_angle: transport::OCTREE_ANGLE,
        }
    }
}

/// A scene but for its mesh, checked.
#[derive(Debug)]
pub(super) struct Draft {
    /// Millimetres per scene unit.
    pub unit_mm: f64,
    /// The camera, perhaps still to be fitted.
    pub framing: Framing,
    /// The lights, in the file's order.
    pub lights: Vec<Light>,
    /// Where the mesh comes from.
    pub source: Source,
    /// Largest extent to give the mesh, in scene units.
    pub size: Option<f64>,
    /// The object's material.
    pub material: Material,
    /// Light transport.
    pub transport: Transport,
}

/// Where a mesh comes from.
#[derive(Debug)]
pub(super) enum Source {
    /// A file, relative to the scene file.
    File(PathBuf),
    /// A shape made here, and its detail.
    Shape(Shape, u32),
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
        let [object] = self.object.as_slice() else {
            let found = match self.object.len() {
                0 => "no [[object]]".to_owned(),
                n => format!("{n} times [[object]]"),
            };
            let fault = Input::new("one object is supported").key("object");
            return Err(fault.found(found).expected("exactly one [[object]]"));
        };
        let size = object.size.map(|size| {
            let accept = |x| (1e-9..=range::LARGEST).contains(&x);
            range::number("object.0.size", size, accept, "1e-9 to 1e9 scene units")
        });
        Ok(Draft {
            unit_mm,
            framing,
            lights,
            source: object.source()?,
            size: size.transpose()?,
            material: Material::check(&object.material, "object.0.material", unit_mm)?,
            transport: Transport::check(&self.transport)?,
        })
    }
}

impl ObjectFile {
    /// Exactly one of `mesh` and `shape`; `detail` only with the latter.
    fn source(&self) -> Checked<Source> {
        let one = "exactly one of `mesh` and `shape`";
        match (&self.mesh, self.shape) {
            (Some(_), Some(_)) => {
                let fault = Input::new("both a mesh and a shape are given");
                Err(fault.key("object.0.shape").expected(one))
            }
            (None, None) => {
                let fault = Input::new("neither a mesh nor a shape is given");
                Err(fault.key("object.0").expected(one))
            }
            (Some(_), None) if self.detail.is_some() => {
                let fault = Input::new("a mesh from a file has no such key");
                Err(fault.key("object.0.detail").expected("mesh, size, material"))
            }
            (Some(path), None) => Ok(Source::File(path.clone())),
            (None, Some(shape)) => {
                let detail = self.detail.unwrap_or_else(|| i64::from(shape.usual_detail()));
                let range = shape.details();
                let accepted = u32::try_from(detail).ok().filter(|detail| range.contains(detail));
                let detail = accepted.ok_or_else(|| {
                    let expected = format!("{} to {}", range.start(), range.end());
                    let fault = Input::new("out of range").key("object.0.detail");
                    fault.found(detail).expected(expected)
                })?;
                Ok(Source::Shape(shape, detail))
            }
        }
    }
}
