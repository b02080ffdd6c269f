//! Which way up a mesh stands, and where the camera stands.

use super::super::Scene;
use super::super::range::Checked;
use super::value;
use crate::error::Input;
use glam::{DMat3, DVec3};
use std::path::Path;
use std::str::FromStr;
use toml::Table;

/// The axis of a mesh that points upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Up {
    /// As in most models.
    Y,
    /// As in most parts to print or to mill.
    Z,
}

/// Where the camera stands around an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewFrom {
    /// Degrees from the front, +z of what stands upright, towards +x.
    pub azimuth: f64,
    /// Degrees above the horizon, -89 to 89.
    pub elevation: f64,
}

/// Views by name: azimuth and elevation. Straight from above or below there is no upright.
const VIEWS: &[(&str, [f64; 2])] = &[
    ("front", [0.0, 0.0]),
    ("back", [180.0, 0.0]),
    ("left", [-90.0, 0.0]),
    ("right", [90.0, 0.0]),
    ("top", [0.0, 89.0]),
];

impl FromStr for ViewFrom {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = VIEWS.iter().find(|(name, _)| *name == text).map(|(_, angles)| *angles);
        let pair = || {
            let (azimuth, elevation) = text.split_once(',')?;
            Some([azimuth.trim().parse().ok()?, elevation.trim().parse().ok()?])
        };
        let sound = |[azimuth, elevation]: &[f64; 2]| azimuth.abs() <= 3600.0 && elevation.abs() <= 89.0;
        let [azimuth, elevation] = named.or_else(pair).filter(sound).ok_or_else(|| {
            let names: Vec<_> = VIEWS.iter().map(|(name, _)| *name).collect();
            format!("expected {}, or AZIMUTH,ELEVATION in degrees, -89 to 89 above the horizon", names.join(", "))
        })?;
        Ok(Self { azimuth, elevation })
    }
}

impl ViewFrom {
    /// Returns an error if the camera would stand below a table.
    pub(super) fn stands(self, ground: bool) -> Checked<()> {
        if !ground || self.elevation >= 0.0 {
            return Ok(());
        }
        let fault = Input::new("the camera would stand below the table").key("--view-from");
        Err(fault.found(self.elevation).expected("an elevation from 0 on, or no --ground"))
    }
}

/// The share of an object's height in which its feet end.
const FEET: f64 = 0.02;
/// From the middle towards the camera: in front, a little to the right and above; and with a table, from higher above.
const FRONT: DVec3 = DVec3::new(0.35, 0.3, 1.0);
const ABOVE: DVec3 = DVec3::new(0.35, 0.5, 1.0);
/// Room around the object, as a factor.
const MARGIN: f64 = 1.15;

impl Up {
    /// The likely axis: that on whose feet the mesh stands more firmly; in doubt z for STL, else y. glTF has y.
    pub(super) fn guess(file: &Path, scene: &Scene) -> Self {
        if is_gltf(file) {
            return Self::Y;
        }
        let points: Vec<DVec3> = points(scene).collect();
        let [y, z] = [1, 2].map(|axis| stands(&points, axis));
        let stl = file.extension().is_some_and(|found| found.eq_ignore_ascii_case("stl"));
        let firm = if stl { y <= 1.5 * z + 0.1 } else { z > 1.5 * y + 0.1 };
        if firm { Self::Z } else { Self::Y }
    }
}

/// Whether a file is glTF, in which y points upwards and +z is the front.
pub(super) fn is_gltf(file: &Path) -> bool {
    file.extension().is_some_and(|found| ["gltf", "glb"].iter().any(|end| found.eq_ignore_ascii_case(end)))
}

/// All vertices, in the scene.
fn points(scene: &Scene) -> impl Iterator<Item = DVec3> + '_ {
    scene.objects.iter().flat_map(|object| object.mesh.positions.iter().map(|&point| object.placed(point)))
}

/// The lowest and highest coordinates.
fn bounds<'a>(points: impl Iterator<Item = &'a DVec3>) -> (DVec3, DVec3) {
    let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.fold(ends, |(low, high), &p| (low.min(p), high.max(p)))
}

/// How firmly points stand if this axis points upwards: the share of their ground plan that their feet span; 0 if they
/// would fall over, or are flat.
fn stands(points: &[DVec3], axis: usize) -> f64 {
    let (low, high) = bounds(points.iter());
    if high[axis] - low[axis] < 1e-3 * (high - low).max_element() {
        return 0.0;
    }
    let ceiling = low[axis] + FEET * (high[axis] - low[axis]);
    let (left, right) = bounds(points.iter().filter(|p| p[axis] <= ceiling));
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let mut share = 1.0;
    for across in (0..3).filter(|across| *across != axis) {
        if !(left[across]..=right[across]).contains(&middle[across]) {
            return 0.0;
        }
        share *= (right[across] - left[across]) / (high[across] - low[across]).max(1e-12);
    }
    share
}

/// Where the camera and the object are.
#[derive(Debug, Clone)]
pub(super) struct Pose {
    /// The middle of the object's box, scene units.
    pub middle: DVec3,
    /// Its lowest point.
    pub floor: f64,
    /// Half its largest extent.
    pub radius: f64,
    /// How far the studio is turned about +y, degrees.
    pub yaw: f64,
    /// The camera and the point it looks at; none if the file has its own.
    camera: Option<(DVec3, DVec3)>,
}

impl Pose {
    /// Around a scene's objects, with the broader side in front, or +z if that is the `front`; `given`: the scene's
    /// camera stays where it is, unless a view is asked for.
    pub fn of(scene: &Scene, ground: bool, [given, front]: [bool; 2], view: Option<ViewFrom>) -> Self {
        let (low, high) = scene.bounds();
        let (middle, size) = ((low + high) / 2.0, high - low);
        let radius = size.max_element() / 2.0;
        let mut pose = Self { middle, floor: low.y, radius, yaw: 0.0, camera: None };
        if given && view.is_none() {
            let toward = scene.camera.position - scene.camera.target;
            pose.yaw = (toward.x.atan2(toward.z) - FRONT.x.atan2(FRONT.z)).to_degrees();
            return pose;
        }
        let usual = if ground { ABOVE } else { FRONT };
        let aside = usual.x.atan2(usual.z);
        let toward = match view {
            // The lights turn with the camera.
            Some(ViewFrom { azimuth, elevation }) => {
                pose.yaw = azimuth - aside.to_degrees();
                let (up, level) = elevation.to_radians().sin_cos();
                DVec3::new(level * aside.sin(), up, level * aside.cos())
            }
            None => {
                pose.yaw = if size.z > 1.2 * size.x && !front { 90.0 } else { 0.0 };
                usual.normalize()
            }
        };
        let tall = (scene.camera.fov.to_radians() / 2.0).tan();
        let wide = tall * f64::from(scene.camera.size[0]) / f64::from(scene.camera.size[1]);
        let turn = pose.turn();
        // Aim at the middle of what is seen, in three steps.
        let right = DVec3::Y.cross(toward).normalize();
        let up = toward.cross(right);
        let mut target = DVec3::ZERO;
        let mut distance = 0.0f64;
        for _ in 0..3 {
            let offsets = points(scene).map(|p| turn.transpose() * (p - middle) - target);
            distance = offsets
                .map(|p| (p.dot(right).abs() / wide).max(p.dot(up).abs() / tall) * MARGIN + p.dot(toward))
                .fold(radius * 1e-3, f64::max);
            let seen = points(scene).map(|p| {
                let p = turn.transpose() * (p - middle) - target;
                DVec3::new(p.dot(right), p.dot(up), 0.0) / (distance - p.dot(toward)).max(1e-9)
            });
            let all: Vec<DVec3> = seen.collect();
            let (low, high) = bounds(all.iter());
            let off = (low + high) / 2.0 * distance;
            target += right * off.x + up * off.y;
        }
        pose.camera = Some((target + toward * distance, target));
        pose
    }

    /// The same, with camera and lights turned further about the object, degrees.
    pub fn turned(&self, by: f64) -> Self {
        Self { yaw: self.yaw + by, ..self.clone() }
    }

    fn turn(&self) -> DMat3 {
        DMat3::from_rotation_y(self.yaw.to_radians())
    }

    /// A direction of the studio, in the scene.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.turn() * direction
    }

    /// A place of the studio, in radii from the middle, in the scene.
    pub fn place_at(&self, place: DVec3) -> DVec3 {
        self.middle + self.direction(place) * self.radius
    }

    /// Writes the camera's position and target, unless the file's own camera stays.
    pub fn place(&self, camera: &mut Table) {
        if let Some(both) = self.camera {
            let [position, target] = [both.0, both.1].map(|p| self.middle + self.direction(p));
            camera.insert("position".into(), value(position));
            camera.insert("target".into(), value(target));
        }
    }
}
