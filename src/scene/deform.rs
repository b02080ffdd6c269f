//! What deforms an object, after it has been given its size and place: in the scene's coordinates.

use super::files::Files;
use super::mesh::{Mesh, Origin};
use super::range::{self, Checked};
use super::vector::Vector;
use crate::error::Input;
use glam::DVec3;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A deformation; lengths in scene units.
#[derive(Debug, Clone, PartialEq)]
pub enum Deform {
    /// Turned about an axis: not at all at the low end, by `angle` radians at the high one and beyond, evenly between.
    Twist {
        /// The axis and its ends.
        span: Span,
        /// Radians, right-handed about the axis.
        angle: f64,
    },
    /// Bent into an arc: the low end stays, the high one is turned by `angle`; what lies beyond either end stays
    /// straight.
    Bend {
        /// The direction that is bent, and its ends.
        span: Span,
        /// Across it, of length 1: where it leans to.
        toward: DVec3,
        /// Radians, not 0.
        angle: f64,
    },
    /// Raised by `height (1 - r^2 / radius^2)^2` within a radius.
    Bump {
        /// Its middle.
        position: DVec3,
        /// Where it ends.
        radius: f64,
        /// How high it is; below 0 a hollow.
        height: f64,
        /// Of length 1; none is along the normals.
        direction: Option<DVec3>,
    },
    /// Raised along the normals by gradient noise, of -1 to 1 times `amplitude`.
    Noise {
        /// Largest height.
        amplitude: f64,
        /// Size of its features.
        scale: f64,
        /// Where its lattice begins.
        offset: DVec3,
    },
    /// Moved towards the places of another mesh of equal topology.
    Morph {
        /// Of each vertex, the way from its place at rest to that of the other mesh.
        ways: Arc<[DVec3]>,
        /// Which share of the way: 1 all of it, -10 to 10.
        weight: f64,
    },
}

/// A stretch of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// A point of the axis.
    pub center: DVec3,
    /// Its direction, of length 1.
    pub axis: DVec3,
    /// Height of the low end along it, from `center`.
    pub low: f64,
    /// From there to the high end, above 0.
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

/// A deformation, checked, but for what the mesh decides.
#[derive(Debug, Clone)]
pub(super) struct Draft {
    deform: Deform,
    center: Option<DVec3>,
    length: Option<f64>,
    /// A morph's other mesh, relative to the scene file.
    other: Option<PathBuf>,
}

/// Most deformations of an object.
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
                }
            }
            Self::Bump { position, radius, height: top, direction: along } => {
                let deform = Deform::Bump {
                    position: range::point(&key("position"), position.0)?,
                    radius: size("radius", *radius)?,
                    height: height("height", *top)?,
                    direction: direction("direction", along)?,
                };
                Draft { deform, center: None, length: None, other: None }
            }
            Self::Noise { amplitude, scale, offset } => {
                let deform = Deform::Noise {
                    amplitude: height("amplitude", *amplitude)?,
                    scale: size("scale", *scale)?,
                    offset: point("offset", offset)?.unwrap_or_default(),
                };
                Draft { deform, center: None, length: None, other: None }
            }
            Self::Morph { mesh, weight } => {
                let weight = range::number(&key("weight"), *weight, |x| x.abs() <= 10.0, "-10 to 10")?;
                let deform = Deform::Morph { ways: Arc::default(), weight };
                Draft { deform, center: None, length: None, other: Some(mesh.clone()) }
            }
        })
    }
}

impl Draft {
    /// Reads a morph's other mesh, from `folder`, which must match the object's own file `own`; none is a shape made
    /// here. `origin` is how the object's vertices come from that file's, `place` how ways are scaled and turned.
    pub(super) fn load(
        &mut self,
        files: &Files,
        folder: &Path,
        own: Option<&Path>,
        origin: &Origin,
        place: impl Fn(DVec3) -> DVec3,
        key: &str,
    ) -> Checked<()> {
        let (Some(other), Deform::Morph { ways, .. }) = (&self.other, &mut self.deform) else { return Ok(()) };
        let Some(own) = own else {
            let fault = Input::new("a shape made here has no file whose vertices another mesh could match");
            return Err(fault.key(key).expected("an object with `mesh`"));
        };
        let ends = Mesh::read_ends(files, &folder.join(own), &folder.join(other), key)?;
        let bytes = ends[0].len().max(origin.vertices()) as u64 * size_of::<DVec3>() as u64;
        files
            .take(bytes)
            .map_err(|error| Input::new(format!("the morph does not fit the memory: {error}")).key(key))?;
        let [rest, other] = ends.map(|places| origin.apply(places));
        *ways = rest.iter().zip(&other).map(|(&from, &to)| place(to - from)).collect();
        Ok(())
    }

    /// The deformation of this mesh: an axis goes through the middle of its box, from its low end to its high one,
    /// where nothing else is said.
    pub(super) fn on(&self, mesh: &Mesh) -> Deform {
        let mut deform = self.deform.clone();
        if let Deform::Twist { span, .. } | Deform::Bend { span, .. } = &mut deform {
            let (low, high) = mesh.bounds();
            span.center = self.center.unwrap_or(0.5 * (low + high));
            let heights = mesh.positions.iter().map(|p| (*p - span.center).dot(span.axis));
            let (least, most) = heights
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), h| (f64::min(least, h), f64::max(most, h)));
            // What is flat across the axis has no ends.
            let whole = if most > least { most - least } else { 1.0 };
            // A length of one's own lies about the middle.
            (span.low, span.length) = self.length.map_or((least, whole), |length| (-0.5 * length, length));
        }
        deform
    }
}
