//! The camera: position, target and picture; what the scene omits is fitted to the objects.

use super::file::CameraFile;
use super::light::{Light, Source};
use super::range::{self, Checked};
use super::vector::{Background, Exposure, Vector};
use crate::error::{Input, Result};
use glam::{DQuat, DVec3};
use serde::Deserialize;
use std::ops::Range;

/// The direction from the object to a fitted camera: from the front, a little above and to the right.
const FRONT: DVec3 = DVec3::new(0.35, 0.3, 1.0);

/// Size of a fitted camera's view relative to the object.
const MARGIN: f64 = 1.08;

/// The vertical field of view when the file gives none, in degrees.
const FOV: f64 = 35.0;

/// The picture size when the file gives none, in pixels.
const SIZE: [u32; 2] = [512, 512];

/// The largest width or height of a picture, in pixels.
pub const LARGEST_SIZE: u32 = 16_384;

/// Tone curve from exposed radiance to a PNG's 0 to 1, before the sRGB curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Linear, clipped at 1.
    #[default]
    Clip,
    /// Hable's curve: a soft shoulder that reaches 1 at 5.6, and a toe.
    Filmic,
}

/// A validated camera: a pinhole, or a thin lens.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// The pinhole or the middle of the lens, in scene units; never equal to `target`.
    pub position: DVec3,
    /// The point in the middle of the picture, in scene units.
    pub target: DVec3,
    /// Approximate up direction, length 1; may be parallel to the view.
    pub up: DVec3,
    /// Vertical field of view in degrees, between 0 and 180.
    pub fov: f64,
    /// Diameter of the lens in scene units, 0 to 1e9: 0 is a pinhole. A picture of one sample is that of a pinhole.
    pub aperture: f64,
    /// Distance along the view of what the lens shows sharp, in scene units, from 1e-9; none: that of `target`.
    pub focus: Option<f64>,
    /// Width and height in pixels, each 1 to 16384.
    pub size: [u32; 2],
    /// Samples of a pixel, which shows their mean, 1 to 64.
    pub samples: u32,
    /// Factor on radiance before it becomes sRGB, above 0. While the exposure is `metered`, 1 until a picture is made.
    pub exposure: f64,
    /// Whether that factor is metered from the picture.
    pub metered: bool,
    /// Tone curve, for PNG only.
    pub tone: Tone,
    /// Linear radiance where no object is seen, r g b, at least 0.
    pub background: [f64; 3],
    /// Whether the environment is shown where no object is seen, instead of `background`.
    pub environment: bool,
    /// Whether pictures are transparent where no object is seen; `background` is black then.
    pub transparent: bool,
}

/// The minimum angle of a pixel, radian: four times the resolution of `f32`.
const NARROWEST: f64 = 4.0 / 16_777_216.0;

/// The widest lens at the distance of focus, in half pixels.
const WIDEST_LENS: f64 = 1e6;

/// The nearest distance of focus, in scene units.
const NEAREST_FOCUS: f64 = 1e-9;

impl Camera {
    /// Right, up and forward: of length 1 and perpendicular, right = forward x up. When `up` is parallel to the view,
    /// the axis least aligned with the view replaces it.
    pub fn basis(&self) -> (DVec3, DVec3, DVec3) {
        frame((self.target - self.position).normalize_or(DVec3::NEG_Z), self.up)
    }

    /// Distance along the view of what is sharp, in scene units.
    pub fn focus(&self) -> f64 {
        self.focus.unwrap_or_else(|| self.position.distance(self.target))
    }

    /// The same camera with another picture size; an error if its pixels are too narrow, or its lens too wide.
    pub fn sized(self, size: [u32; 2]) -> Result<Self> {
        let camera = Self { size, ..self };
        camera.wide_enough()?;
        camera.small_lens()?;
        Ok(camera)
    }

    /// A camera that looks the same way at the middle of the box `low..high`, from so far that every corner is in the
    /// picture.
    #[must_use]
    pub fn fitted(&self, low: DVec3, high: DVec3) -> Self {
        let (_, _, forward) = self.basis();
        let target = (low + high) / 2.0;
        Self { position: target - forward * distance(self, target, forward, low, high), target, ..self.clone() }
    }

    /// The same camera, turned by `degrees` about the axis through `middle` that points upwards.
    #[must_use]
    pub fn turned(&self, middle: DVec3, degrees: f64) -> Self {
        let turn = DQuat::from_axis_angle(self.up, degrees.to_radians());
        let [position, target] = [self.position, self.target].map(|place| middle + turn * (place - middle));
        Self { position, target, ..self.clone() }
    }

    /// Checks the angle of a pixel: rays and positions are `f32`, and those of neighbours must differ by more than
    /// rounding.
    fn wide_enough(&self) -> Checked<()> {
        let lines = f64::from(self.size[1]);
        if 2.0 * (self.fov.to_radians() / 2.0).tan() / lines >= NARROWEST {
            return Ok(());
        }
        let fault = Input::new("too narrow for a picture of so many lines").key("camera.fov").found(self.fov);
        let least = (0.5 * NARROWEST * lines).atan().to_degrees() * 2.0;
        Err(fault.expected(format!("at least {least:.1e} degrees for {lines} lines")))
    }

    /// The lens's diameter at the distance of focus, in half pixels.
    pub fn lens(&self) -> f64 {
        if self.aperture == 0.0 {
            return 0.0;
        }
        self.aperture * f64::from(self.size[1]) / (self.focus() * (self.fov.to_radians() / 2.0).tan())
    }

    /// Checks the lens: it shifts rays by so many pixels, as `f32`.
    fn small_lens(&self) -> Checked<()> {
        if self.lens() <= WIDEST_LENS {
            return Ok(());
        }
        let fault = Input::new("too wide a lens for its distance of focus").key("camera.aperture").found(self.aperture);
        let most = self.aperture * WIDEST_LENS / self.lens();
        let focus = self.focus();
        Err(fault.expected(format!("at most {most:.1e} for a focus at {focus:.1e}, or a camera.focus farther away")))
    }
}

/// The camera of the file, validated; [`Framing::fit`] fills in what is omitted.
#[derive(Debug, Clone)]
pub(super) struct Framing {
    position: Option<DVec3>,
    target: Option<DVec3>,
    rest: Camera,
}

impl Framing {
    /// Checks `[camera]`.
    pub(super) fn check(file: &CameraFile) -> Checked<Self> {
        let at = |key, value: Option<Vector>| value.map(|v| range::point(key, v.0)).transpose();
        let position = at("camera.position", file.position)?;
        let target = at("camera.target", file.target)?;
        if let (Some(position), Some(target)) = (position, target) {
            apart(position, target)?;
        }
        // Accepts numbers above the range's start and below its end.
        let number = |key: &str, given: Option<f64>, usual: f64, range: Range<f64>, expected: &str| {
            let inside = |x| range.start < x && x < range.end;
            range::number(&format!("camera.{key}"), given.unwrap_or(usual), inside, expected)
        };
        let before = |x: f64| (NEAREST_FOCUS..=range::LARGEST).contains(&x);
        let focus = file.focus.map(|focus| range::number("camera.focus", focus, before, "1e-9 to 1e9"));
        let lens = |x: f64| (0.0..=range::LARGEST).contains(&x);
        let rest = Camera {
            aperture: range::number("camera.aperture", file.aperture.unwrap_or(0.0), lens, "0 to 1e9")?,
            focus: focus.transpose()?,
            position: DVec3::ZERO,
            target: DVec3::ZERO,
            up: file.up.map_or(Ok(DVec3::Y), |up| range::direction("camera.up", up.0))?,
            fov: number("fov", file.fov, FOV, 0.0..180.0, "degrees, above 0 and below 180")?,
            size: file.size.as_deref().map_or(Ok(SIZE), size)?,
            samples: number("samples", file.samples.map(f64::from), 1.0, 0.0..65.0, "a whole number from 1 to 64")?
                as u32,
            exposure: match file.exposure {
                None | Some(Exposure::Auto) => 1.0,
                Some(Exposure::Factor(x)) => {
                    number("exposure", Some(x), 1.0, 0.0..f64::INFINITY, "above 0, or \"auto\"")?
                }
            },
            metered: file.exposure == Some(Exposure::Auto),
            tone: file.tone,
            background: match file.background {
                Background::Environment | Background::None => [0.0; 3],
                Background::Color(color) => {
                    let accept = |x| (0.0..=1e20).contains(&x);
                    range::channels("camera.background", color, accept, "numbers from 0 to 1e20")?
                }
            },
            environment: file.background == Background::Environment,
            transparent: file.background == Background::None,
        };
        rest.wide_enough()?;
        Ok(Self { position, target, rest })
    }

    /// Width and height of the picture, in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.rest.size
    }

    /// Returns an error if the background is the environment but no light is one.
    pub(super) fn check_background(&self, lights: &[Light]) -> Checked<()> {
        if !self.rest.environment || lights.iter().any(|light| matches!(light.source, Source::Environment { .. })) {
            return Ok(());
        }
        let fault = Input::new("no light is an environment").key("camera.background").found("\"environment\"");
        Err(fault.expected("a number, [r, g, b] or \"none\", or a [[light]] of type \"environment\""))
    }

    /// The camera, with a missing position or target fitted to the box `low..high`.
    pub(super) fn fit(&self, low: DVec3, high: DVec3) -> Checked<Camera> {
        let target = self.target.unwrap_or((low + high) / 2.0);
        let position = self.position.unwrap_or_else(|| {
            let back = FRONT.normalize();
            target + back * distance(&self.rest, target, -back, low, high)
        });
        apart(position, target)?;
        let camera = Camera { position, target, ..self.rest.clone() };
        camera.small_lens()?;
        Ok(camera)
    }
}

/// Distance from `target` at which a camera that looks `forward` sees every corner of the box.
fn distance(camera: &Camera, target: DVec3, forward: DVec3, low: DVec3, high: DVec3) -> f64 {
    let (right, up, forward) = frame(forward, camera.up);
    let tall = (camera.fov.to_radians() / 2.0).tan();
    let wide = tall * f64::from(camera.size[0]) / f64::from(camera.size[1]);
    let needed = (0..8).map(|corner| {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 { low[axis] } else { high[axis] }
        };
        let offset = DVec3::new(pick(0), pick(1), pick(2)) - target;
        let across = (offset.dot(right).abs() / wide).max(offset.dot(up).abs() / tall);
        across * MARGIN - offset.dot(forward)
    });
    needed.fold(0.0, f64::max) + (high - low).length() * 1e-3
}

/// Right, up and forward from a view direction of length 1 and an approximate up direction.
fn frame(forward: DVec3, up: DVec3) -> (DVec3, DVec3, DVec3) {
    let cross = forward.cross(up);
    let right = if cross.length() > 1e-6 {
        cross.normalize()
    } else {
        let size = forward.abs();
        let axis = if size.z <= size.x && size.z <= size.y {
            DVec3::NEG_Z
        } else if size.y <= size.x {
            DVec3::Y
        } else {
            DVec3::X
        };
        forward.cross(axis).normalize()
    };
    (right, right.cross(forward), forward)
}

/// Returns an error if the camera stands on its target.
fn apart(position: DVec3, target: DVec3) -> Checked<()> {
    if position.distance(target) > 1e-9 * position.length().max(1e-6) {
        return Ok(());
    }
    let found = format!("[{}, {}, {}] for both", target.x, target.y, target.z);
    let what = "the camera stands on the point it looks at";
    Err(Input::new(what).key("camera.position").found(found).expected("two different points"))
}

/// Width and height in pixels.
fn size(found: &[i64]) -> Checked<[u32; 2]> {
    let pixels = |value: &i64| u32::try_from(*value).ok().filter(|n| (1..=LARGEST_SIZE).contains(n));
    if let [width, height] = found
        && let (Some(width), Some(height)) = (pixels(width), pixels(height))
    {
        return Ok([width, height]);
    }
    let expected = format!("[width, height], each 1 to {LARGEST_SIZE} pixels");
    let fault = Input::new("not a picture size").key("camera.size");
    Err(fault.found(format!("{found:?}")).expected(expected))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn framing(text: &str) -> std::result::Result<Framing, String> {
        let file: CameraFile = toml::from_str(text).map_err(|e| e.message().to_string())?;
        Framing::check(&file).map_err(|e| e.to_string())
    }

    fn fitted(text: &str) -> std::result::Result<Camera, String> {
        framing(text)?.fit(DVec3::splat(-1.0), DVec3::new(1.0, 3.0, 1.0)).map_err(|e| e.to_string())
    }

    #[test]
    fn the_fitted_camera_sees_every_corner() {
        for text in ["", "size = [100, 400]", "fov = 170", "up = [0.35, 0.3, 1.0]", "target = [4, 0, 0]"] {
            let camera = fitted(text).expect(text);
            let (right, up, forward) = camera.basis();
            let tall = (camera.fov.to_radians() / 2.0).tan();
            let wide = tall * f64::from(camera.size[0]) / f64::from(camera.size[1]);
            for corner in 0..8 {
                let pick = |axis: usize, low, high| if corner >> axis & 1 == 0 { low } else { high };
                let corner = DVec3::new(pick(0, -1.0, 1.0), pick(1, -1.0, 3.0), pick(2, -1.0, 1.0));
                let seen = corner - camera.position;
                let depth = seen.dot(forward);
                assert!(depth > 0.0 && seen.dot(right).abs() <= depth * wide, "{text}");
                assert!(seen.dot(up).abs() <= depth * tall, "{text}");
            }
            let again = camera.fitted(DVec3::splat(-1.0), DVec3::new(1.0, 3.0, 1.0));
            assert!(again.basis().2.distance(forward) < 1e-12 && again.target == DVec3::Y, "{text}");
            assert!(text.contains("target") || again.position.distance(camera.position) < 1e-9, "{text}");
        }
    }

    #[test]
    fn a_turned_camera_goes_round_the_middle() {
        let camera = fitted("position = [1, 5, 4]\ntarget = [1, 1, 0]").expect("a camera");
        let middle = DVec3::new(1.0, 2.0, 1.0);
        let quarter = camera.turned(middle, 90.0);
        assert!(quarter.position.distance(DVec3::new(4.0, 5.0, 1.0)) < 1e-12, "{}", quarter.position);
        assert!(quarter.target.distance(DVec3::new(0.0, 1.0, 1.0)) < 1e-12, "{}", quarter.target);
        assert!(camera.turned(middle, 360.0).position.distance(camera.position) < 1e-12);
    }

    #[test]
    fn the_basis_is_orthonormal_for_every_up() {
        for up in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Y, DVec3::ONE.normalize()] {
            for view in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z, -DVec3::ONE] {
                let mut camera = fitted("").expect("defaults");
                camera.up = up;
                camera.target = camera.position + view;
                let (r, u, f) = camera.basis();
                assert!((r.cross(u) + f).length() < 1e-12 && (r.length() - 1.0).abs() < 1e-12);
                assert!((f - view.normalize()).length() < 1e-12 && r.dot(u).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn names_the_key_at_fault() {
        let cases = [
            ("aperture = -1", "camera.aperture: out of range; found -1; expected 0 to 1e9"),
            ("focus = 1e-10", "camera.focus: out of range; found 0.0000000001; expected 1e-9 to 1e9"),
            (
                "focus = 1e-9\naperture = 1",
                "camera.aperture: too wide a lens for its distance of focus; found 1; expected at",
            ),
            ("fov = 180", "camera.fov: out of range; found 180; expected degrees, above 0"),
            ("size = [0, 512]", "camera.size: not a picture size; found [0, 512]; expected [width"),
            ("size = [5]", "camera.size: not a picture size; found [5]"),
            ("exposure = 0", "camera.exposure: out of range; found 0; expected above 0, or \"auto\""),
            ("up = [0, 0, 0]", "camera.up: a direction of length zero"),
            ("background = -1", "camera.background: out of range; found [-1, -1, -1]"),
            ("position = [1, 1, 1]\ntarget = [1, 1, 1]", "camera.position: the camera stands on"),
            ("position = [nan, 1, 1]", "camera.position: not a finite number; found [NaN, 1, 1]"),
        ];
        for (text, message) in cases {
            let error = fitted(text).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
        assert!(fitted("position = [0, 1, 0]").is_err_and(|e| e.contains("camera stands")));
    }
}
