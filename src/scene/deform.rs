//! Deformations of an object, in scene coordinates, applied after it is scaled and placed.

use super::files::Files;
use super::mesh::{Mesh, Origin, animations};
use super::play::Play;
use super::range::{self, Checked};
use super::skin::{Pose, Rig};
use super::vector::Vector;
use crate::error::Input;
use glam::{DMat4, DVec3};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A deformation; lengths in scene units.
#[derive(Debug, Clone, PartialEq)]
pub enum Deform {
    /// Rotation about an axis that grows linearly along it: 0 at the low end and below, `angle` radians at the high end
    /// and beyond.
    Twist {
        /// The axis and its ends.
        span: Span,
        /// Radians, right-handed about the axis.
        angle: f64,
    },
    /// Bend into an arc: the low end stays, the high end is rotated by `angle`; parts beyond either end stay straight.
    Bend {
        /// The axis that is bent, and its ends.
        span: Span,
        /// The direction of the bend, perpendicular to the axis, length 1.
        toward: DVec3,
        /// Radians; 0 bends nothing.
        angle: f64,
    },
    /// Displacement by `height (1 - r^2 / radius^2)^2` within a radius.
    Bump {
        /// The centre.
        position: DVec3,
        /// The radius at which it ends.
        radius: f64,
        /// The height; negative for a hollow.
        height: f64,
        /// The direction, length 1; none for along the normals.
        direction: Option<DVec3>,
    },
    /// Displacement along the normals by gradient noise from -1 to 1, times `amplitude`.
    Noise {
        /// Maximum height.
        amplitude: f64,
        /// Feature size.
        scale: f64,
        /// Origin of the noise lattice.
        offset: DVec3,
    },
    /// Interpolation towards another mesh of equal topology.
    Morph {
        /// For each vertex the vector from its rest position to its position in the other mesh.
        ways: Arc<[DVec3]>,
        /// Factor on `ways`, -10 to 10: 1 gives the other mesh.
        weight: f64,
    },
    /// Vertices placed by joints, whatever their place at rest; the first deformation of an object.
    Skin {
        /// What the vertices follow.
        rig: Arc<Rig>,
        /// Where the joints are.
        pose: Arc<Pose>,
    },
}

/// A section of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// A point on the axis.
    pub center: DVec3,
    /// Its direction, of length 1.
    pub axis: DVec3,
    /// Position of the low end along the axis, from `center`.
    pub low: f64,
    /// Length from the low to the high end, above 0.
    pub length: f64,
}

/// `[[object.deform]]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum DeformFile {
    Twist { angle: f64, axis: Option<Vector>, center: Option<Vector>, length: Option<f64> },
    Bend { angle: f64, axis: Option<Vector>, toward: Option<Vector>, center: Option<Vector>, length: Option<f64> },
    Bump { position: Vector, radius: f64, height: f64, direction: Option<Vector> },
    Noise { amplitude: f64, scale: f64, offset: Option<Vector> },
    Morph { mesh: PathBuf, weight: f64 },
}

/// A validated deformation, without the values that depend on the mesh.
#[derive(Debug, Clone)]
pub(super) struct Draft {
    deform: Deform,
    center: Option<DVec3>,
    length: Option<f64>,
    /// File of a morph's other mesh, relative to the scene file.
    other: Option<PathBuf>,
    /// A skin's pose at rest, in the frame of the file.
    rest: Pose,
}

/// Maximum number of deformations of an object.
const MOST: usize = 64;

/// Checks an object's deformations.
pub(super) fn check_all(files: &[DeformFile], key: &str) -> Checked<Vec<Draft>> {
    if files.len() > MOST {
        let found = format!("{} times", files.len());
        return Err(Input::new("too many deformations").key(key).found(found).expected(format!("at most {MOST}")));
    }
    files.iter().enumerate().map(|(number, file)| file.check(&format!("{key}.{number}"))).collect()
}

impl DeformFile {
    fn check(&self, key: &str) -> Checked<Draft> {
        let key = |name: &str| format!("{key}.{name}");
        let angle = |x: f64| range::number(&key("angle"), x, |x| x.abs() <= 36_000.0, "degrees, -36000 to 36000");
        let point = |name: &str, v: &Option<Vector>| v.map(|v| range::point(&key(name), v.0)).transpose();
        let direction = |name: &str, v: &Option<Vector>| v.map(|v| range::direction(&key(name), v.0)).transpose();
        let size = |name: &str, x: f64| {
            range::number(&key(name), x, |x| (1e-9..=range::LARGEST).contains(&x), "1e-9 to 1e9 scene units")
        };
        let height =
            |name: &str, x: f64| range::number(&key(name), x, |x| x.abs() <= range::LARGEST, "within 1e9 scene units");
        let span = |axis| Span { center: DVec3::ZERO, axis, low: 0.0, length: 1.0 };
        let along = |axis: &Option<Vector>| Ok(span(direction("axis", axis)?.unwrap_or(DVec3::Y)));
        Ok(match self {
            Self::Twist { angle: turn, axis, center, length } => Draft {
                deform: Deform::Twist { span: along(axis)?, angle: angle(*turn)?.to_radians() },
                center: point("center", center)?,
                length: length.map(|x| size("length", x)).transpose()?,
                other: None,
                rest: Pose::default(),
            },
            Self::Bend { angle: turn, axis, toward, center, length } => {
                let span = along(axis)?;
                let wish = direction("toward", toward)?;
                let wished = wish.unwrap_or_else(|| span.axis.any_orthonormal_vector());
                let across = wished - wished.dot(span.axis) * span.axis;
                if across.length() < 1e-3 {
                    let fault = Input::new("a bend leans across its axis, not along it").key(key("toward"));
                    let found = toward.map(|v| format!("{:?}", v.0)).unwrap_or_default();
                    return Err(fault.found(found).expected("another direction than `axis`"));
                }
                Draft {
                    deform: Deform::Bend { span, toward: across.normalize(), angle: angle(*turn)?.to_radians() },
                    center: point("center", center)?,
                    length: length.map(|x| size("length", x)).transpose()?,
                    other: None,
                    rest: Pose::default(),
                }
            }
            Self::Bump { position, radius, height: top, direction: along } => {
                let deform = Deform::Bump {
                    position: range::point(&key("position"), position.0)?,
                    radius: size("radius", *radius)?,
                    height: height("height", *top)?,
                    direction: direction("direction", along)?,
                };
                Draft { deform, center: None, length: None, other: None, rest: Pose::default() }
            }
            Self::Noise { amplitude, scale, offset } => {
                let deform = Deform::Noise {
                    amplitude: height("amplitude", *amplitude)?,
                    scale: size("scale", *scale)?,
                    offset: point("offset", offset)?.unwrap_or_default(),
                };
                Draft { deform, center: None, length: None, other: None, rest: Pose::default() }
            }
            Self::Morph { mesh, weight } => {
                let weight = range::number(&key("weight"), *weight, |x| x.abs() <= 10.0, "-10 to 10")?;
                let deform = Deform::Morph { ways: Arc::default(), weight };
                Draft { deform, center: None, length: None, other: Some(mesh.clone()), rest: Pose::default() }
            }
        })
    }
}

impl Draft {
    /// The pose of a file's mesh that `play` asks for, if the file has such an animation.
    pub(super) fn played(files: &Files, source: (&Path, Option<u32>), play: &mut Play) -> Checked<Option<Self>> {
        let Some(number) = play.find(animations(files, source.0)?) else { return Ok(None) };
        let (rig, [rest, now]) = Mesh::read_animated(files, source, (number, play.time))?;
        let deform = Deform::Skin { rig: Arc::new(rig), pose: Arc::new(now) };
        Ok(Some(Self { deform, center: None, length: None, other: None, rest }))
    }

    /// Places a skin's poses in the scene, or reads a morph's other mesh, relative to `folder`. That must match
    /// `source`, the object's file and the part of it, none for a built-in shape. `origin` maps the vertices of that
    /// file to the object's, `placed` places them in the scene.
    pub(super) fn load(
        &mut self,
        files: &Files,
        folder: &Path,
        source: Option<(&Path, Option<u32>)>,
        origin: &Origin,
        placed: DMat4,
        key: &str,
    ) -> Checked<()> {
        if let Deform::Skin { rig, pose } = &mut self.deform {
            match origin {
                Origin::File => {
                    let matrices = pose.matrices.iter().map(|matrix| placed * *matrix).collect();
                    *pose = Arc::new(Pose { matrices, weights: pose.weights.clone() });
                }
                // Vertices between those of the file follow no joints, but go with their neighbours.
                _ => {
                    let [rest, now] = [&self.rest, pose].map(|pose| origin.apply(rig.place(pose)));
                    let ways = rest.iter().zip(&now).map(|(&from, &to)| placed.transform_vector3(to - from)).collect();
                    self.deform = Deform::Morph { ways, weight: 1.0 };
                }
            }
            return Ok(());
        }
        let (Some(other), Deform::Morph { ways, .. }) = (&self.other, &mut self.deform) else { return Ok(()) };
        let Some((file, part)) = source else {
            let fault = Input::new("a built-in shape has no file whose vertices another mesh could match");
            return Err(fault.key(key).expected("an object with `mesh`"));
        };
        let ends = Mesh::read_ends(files, (&folder.join(file), part), &folder.join(other), key)?;
        let bytes = ends[0].len().max(origin.vertices()) as u64 * size_of::<DVec3>() as u64;
        files
            .take(bytes)
            .map_err(|error| Input::new(format!("the morph does not fit the memory: {error}")).key(key))?;
        let [rest, other] = ends.map(|places| origin.apply(places));
        *ways = rest.iter().zip(&other).map(|(&from, &to)| placed.transform_vector3(to - from)).collect();
        Ok(())
    }

    /// The deformation for this mesh. By default, an axis passes through the centre of the bounding box, and its ends
    /// are those of the mesh.
    pub(super) fn on(&self, mesh: &Mesh) -> Deform {
        let mut deform = self.deform.clone();
        if let Deform::Twist { span, .. } | Deform::Bend { span, .. } = &mut deform {
            let (low, high) = mesh.bounds();
            span.center = self.center.unwrap_or(0.5 * (low + high));
            let heights = mesh.positions.iter().map(|p| (*p - span.center).dot(span.axis));
            let (least, most) = heights
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), h| (f64::min(least, h), f64::max(most, h)));
            // A mesh that is flat across the axis has no extent along it.
            let whole = if most > least { most - least } else { 1.0 };
            // A length that is given is centred on `center`.
            (span.low, span.length) = self.length.map_or((least, whole), |length| (-0.5 * length, length));
        }
        deform
    }
}
