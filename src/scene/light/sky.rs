//! An environment: radiance from every direction, as a latitude-longitude image.
//!
//! The top row is up (+y), the middle of the image looks along -z, and +x is to the right of it: the direction of a
//! pixel at polar angle t and azimuth a (-180 to 180 degrees from left to right) is (sin t sin a, cos t, -sin t cos a).
//! `rotation` turns the environment about +y, anticlockwise as seen from above.

use super::super::files::Files;
use super::super::image::{clamp, read_exr, read_hdr};
use super::super::range::Checked;
use super::sun::Sun;
use crate::error::Input;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

/// The name of the built-in sky.
const BUILTIN: &str = "builtin:sky";
/// The name of the built-in surroundings of a studio.
const STUDIO: &str = "builtin:studio";
/// Maximum pixels of an image: as many as the smallest devices can bind.
const MOST_PIXELS: usize = 1 << 23;

/// Radiance from every direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// Width and height of the image, in pixels.
    pub size: [u32; 2],
    /// Its pixels, row by row from the top, finite and at least 0.
    pub pixels: Arc<Vec<[f32; 3]>>,
    /// Factor on the pixels, r g b, at least 0.
    pub factor: [f64; 3],
    /// Rotation about +y, degrees.
    pub rotation: f64,
    /// The file that the pixels are still to be read from, if any.
    image: Option<String>,
    /// Whether a sun in that file becomes a light of its own.
    pub(super) seeks_sun: bool,
    pub(super) sun: Option<Sun>,
}

impl Sky {
    /// A sky of these pixels, row by row from the top.
    pub fn new(size: [u32; 2], pixels: Vec<[f32; 3]>) -> Self {
        let (factor, rotation, image) = ([1.0; 3], 0.0, None);
        Self { size, pixels: Arc::new(pixels), factor, rotation, image, seeks_sun: true, sun: None }
    }

    /// Whether the radiance is the same from all directions and comes from no image.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.image.is_none() && self.size == [1, 1] && self.pixels[..] == [[1.0; 3]]
    }

    /// Whether its image is a file, which is still to be read.
    pub(super) fn is_read(&self) -> bool {
        self.image.is_some()
    }

    /// A sky with the same radiance from all directions.
    pub(super) fn constant(radiance: [f64; 3], factor: [f64; 3]) -> Self {
        let factor = std::array::from_fn(|c| radiance[c] * factor[c]);
        Self { factor, ..Self::new([1, 1], vec![[1.0; 3]]) }
    }

    /// A sky from a file, which is read later, or the built-in sky.
    pub(in crate::scene) fn of_image(image: &str, factor: [f64; 3], rotation: f64) -> Self {
        let mut sky = match image {
            BUILTIN => drawn(sky),
            STUDIO => drawn(studio),
            _ => Self { image: Some(image.to_owned()), ..Self::new([0, 0], Vec::new()) },
        };
        (sky.factor, sky.rotation) = (factor, rotation);
        sky
    }

    /// Reads the image file, if there is one; `key` is the light's key, for errors. What is clamped is added to
    /// `report`.
    pub(in crate::scene) fn load(
        &mut self,
        files: &Files,
        folder: &Path,
        key: &str,
        report: &mut Vec<String>,
    ) -> Checked<()> {
        let Some(image) = self.image.take() else { return Ok(()) };
        let path = folder.join(&image);
        let at = |what: String| Input::new(what).key(format!("{key}.image"));
        let expected = format!("an image that ends in .exr or .hdr, {BUILTIN} or {STUDIO}");
        let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
        let read = match end.as_str() {
            "exr" => read_exr(files, &path, MOST_PIXELS, report),
            "hdr" => read_hdr(files, &path, MOST_PIXELS),
            _ => return Err(at("not the name of an environment".into()).found(image).expected(expected)),
        };
        let (size, mut pixels) =
            read.map_err(|error| at(format!("{}: the image cannot be read", path.display())).found(error))?;
        if pixels.is_empty() || pixels.len() > MOST_PIXELS {
            let fault = at(format!("{}: the image has too few or too many pixels", path.display()));
            let found = format!("{} x {}", size[0], size[1]);
            return Err(fault.found(found).expected(format!("1 to {MOST_PIXELS} pixels")));
        }
        if let Err(place) = clamp(&mut pixels, 3, f32::MAX, &path, report) {
            let (x, y, [r, g, b]) = (place % size[0] as usize, place / size[0] as usize, pixels[place]);
            let fault = at(format!("{}: pixel ({x}, {y}), from the top left, is no radiance", path.display()));
            return Err(fault.found(format!("[{r}, {g}, {b}]")).expected("finite numbers"));
        }
        (self.size, self.pixels) = (size, Arc::new(pixels));
        if self.seeks_sun {
            *self = std::mem::replace(self, Self::new([0; 2], Vec::new())).with_sun();
        }
        report.extend(self.sun.map(|sun| format!("{key}: {sun}")));
        Ok(())
    }

    /// The largest value of each channel.
    pub fn brightest(&self) -> [f64; 3] {
        let largest = |c: usize| f64::from(self.pixels.iter().map(|pixel| pixel[c]).fold(0.0, f32::max));
        std::array::from_fn(|c| largest(c) * self.factor[c])
    }

    /// Radiance of the pixel at `column`, `row`.
    pub fn radiance(&self, column: u32, row: u32) -> DVec3 {
        let pixel = self.pixels[row as usize * self.size[0] as usize + column as usize];
        DVec3::from_array(pixel.map(f64::from)) * DVec3::from_array(self.factor)
    }

    /// The polar angle from +y of the upper edge of `row`; of the lower edge of the image for the row after the last.
    pub fn polar(&self, row: u32) -> f64 {
        PI * f64::from(row) / f64::from(self.size[1])
    }

    /// The azimuth of the left edge of `column`, with the rotation.
    pub fn azimuth(&self, column: u32) -> f64 {
        TAU * (f64::from(column) / f64::from(self.size[0]) - 0.5) - self.rotation.to_radians()
    }

    /// The mean radiance of all directions, the sun's among them.
    pub fn mean(&self) -> DVec3 {
        let row = |row: u32| {
            let share = (self.polar(row).cos() - self.polar(row + 1).cos()) / 2.0;
            (0..self.size[0]).map(|column| self.radiance(column, row)).sum::<DVec3>() * share
        };
        let sun = self.sun().map_or(DVec3::ZERO, |(_, irradiance, _)| DVec3::from_array(irradiance) / (4.0 * PI));
        (0..self.size[1]).map(row).sum::<DVec3>() / f64::from(self.size[0].max(1)) + sun
    }
}

/// Blue above, grey below, with a warm glow low on one side: a polynomial of degree 2 in the direction.
fn sky(direction: DVec3) -> DVec3 {
    let glow = DVec3::new(0.6, 0.25, -0.76).normalize();
    let high = 0.5 + 0.5 * direction.y;
    let warm = (0.5 + 0.5 * direction.dot(glow)).powi(2);
    DVec3::new(0.10, 0.09, 0.08) + high * high * DVec3::new(0.35, 0.55, 0.90) + warm * DVec3::new(1.00, 0.70, 0.35)
}

/// A grey room, brighter above, with a bright spot on the wall that a camera in front sees behind its object.
fn studio(direction: DVec3) -> DVec3 {
    let spot = DVec3::new(-0.3, -0.26, -0.92).normalize();
    let off = spot.angle_between(direction);
    let high = 0.5 + 0.5 * direction.y;
    DVec3::new(0.96, 0.98, 1.0) * (0.03 + 0.19 * (-(off / 0.33).powi(2)).exp() + 0.25 * high.powi(4))
}

/// An image of this radiance by direction.
fn drawn(radiance: impl Fn(DVec3) -> DVec3) -> Sky {
    let [width, height] = [64u32, 32];
    let pixel = |column: u32, row: u32| {
        let (t, a) = (PI * (f64::from(row) + 0.5) / 32.0, TAU * ((f64::from(column) + 0.5) / 64.0 - 0.5));
        let sum = radiance(DVec3::new(t.sin() * a.sin(), t.cos(), -t.sin() * a.cos()));
        [sum.x as f32, sum.y as f32, sum.z as f32]
    };
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| pixel(column, row))).collect();
    Sky::new([width, height], pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let pixel = |x: usize, y: usize| (x as f32, 0.5 * y as f32, 3.0);
        exr::prelude::write_rgb_file(folder.path().join("a.exr"), 4, 2, pixel).expect("written");
        let mut sky = Sky::of_image("a.exr", [2.0, 1.0, 1.0], 0.0);
        sky.load(&Files::default(), folder.path(), "light.0", &mut Vec::new()).expect("an image");
        assert_eq!((sky.size, sky.radiance(3, 1)), ([4, 2], DVec3::new(6.0, 0.5, 3.0)));
        assert_eq!(sky.brightest(), [6.0, 0.5, 3.0]);
        assert!((sky.mean() - DVec3::new(3.0, 0.25, 3.0)).length() < 1e-12, "{}", sky.mean());
        let file = std::fs::File::create(folder.path().join("b.hdr")).expect("created");
        let pixels: Vec<_> = (0..32).map(|i| image::Rgb([i as f32, 1.0, 0.0])).collect();
        image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, 8, 4).expect("written");
        let mut sky = Sky::of_image("b.hdr", [1.0; 3], 0.0);
        sky.load(&Files::default(), folder.path(), "light.0", &mut Vec::new()).expect("an image");
        assert_eq!((sky.size, sky.radiance(3, 1).x), ([8, 4], 11.0));
    }

    #[test]
    fn pixels_a_little_below_0_are_0_and_counted() {
        let folder = tempfile::tempdir().expect("a folder");
        let pixel = |x: usize, y: usize| (if (x, y) == (2, 1) { -3e-6 } else { 1.0 }, -1e-7 * x as f32, 1e30f32);
        exr::prelude::write_rgb_file(folder.path().join("a.exr"), 4, 2, pixel).expect("written");
        let (mut sky, mut report) = (Sky::of_image("a.exr", [1.0; 3], 0.0), Vec::new());
        sky.load(&Files::default(), folder.path(), "light.0", &mut report).expect("an image");
        assert_eq!((sky.pixels[6], sky.pixels[1]), ([0.0, 0.0, 1e30], [1.0, 0.0, 1e30]));
        assert!(report.len() == 1 && report[0].starts_with("clamped: 6 of 8 pixels of "), "{report:?}");
        assert!(report[0].ends_with("a.exr, the least -3e-6"), "{report:?}");
    }

    #[test]
    fn a_bad_pixel_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        for (value, shown) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
            let pixel = move |x: usize, y: usize| (1.0, if (x, y) == (2, 1) { value } else { 1.0 }, 1.0f32);
            exr::prelude::write_rgb_file(folder.path().join("a.exr"), 4, 2, pixel).expect("written");
            let mut sky = Sky::of_image("a.exr", [1.0; 3], 0.0);
            let loaded = sky.load(&Files::default(), folder.path(), "light.0", &mut Vec::new());
            let error = loaded.err().map(|e| e.to_string()).unwrap_or_default();
            let what = "a.exr: pixel (2, 1), from the top left, is no radiance; found [1, ";
            assert!(error.starts_with("light.0.image: ") && error.contains(&format!("{what}{shown}, 1]")), "{error}");
        }
    }
}
