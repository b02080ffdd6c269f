//! Turns `[[light]]` of the file into a validated light.

use super::super::object::Object;
use super::super::range::{self, Checked};
use super::super::vector::{Rgb, Vector};
use super::file::{LightFile, LightKind};
use super::{Light, Sky, Source};
use crate::error::Input;
use glam::DVec3;

/// A kind's name, its required keys, and its optional keys besides `type`.
type Keys = (&'static str, &'static [&'static str], &'static [&'static str]);

fn keys(kind: LightKind) -> Keys {
    match kind {
        LightKind::Directional => ("directional", &["direction", "irradiance"], &["shadows"]),
        LightKind::Point => ("point", &["position", "intensity"], &["shadows"]),
        LightKind::Spot => ("spot", &["position", "direction", "intensity", "outer"], &["inner", "shadows"]),
        LightKind::Area => {
            ("area", &["position", "edge_u", "edge_v", "radiance"], &["two_sided", "samples", "shadows"])
        }
        LightKind::Environment => ("environment", &[], &["image", "radiance", "intensity", "rotation", "occlusion"]),
    }
}

/// A kind's name with its article.
fn article(kind: &str) -> String {
    let an = if kind.starts_with(['a', 'e']) { "an" } else { "a" };
    format!("{an} {kind}")
}

/// One light of the file, and its index there.
struct Reader<'a> {
    file: &'a LightFile,
    index: usize,
    kind: &'static str,
    accepted: String,
}

impl Reader<'_> {
    fn key(&self, name: &str) -> String {
        format!("light.{}.{name}", self.index)
    }

    fn needed<T>(&self, name: &str, value: Option<T>) -> Checked<T> {
        value.ok_or_else(|| {
            let what = format!("missing: {} light needs it", article(self.kind));
            Input::new(what).key(self.key(name)).expected(&self.accepted)
        })
    }

    fn amount(&self, name: &str, value: Option<Rgb>) -> Checked<[f64; 3]> {
        let value = self.needed(name, value)?.0;
        range::channels(&self.key(name), value, |x| (0.0..=1e30).contains(&x), "numbers from 0 to 1e30")
    }

    fn position(&self) -> Checked<DVec3> {
        range::point(&self.key("position"), self.needed("position", self.file.position)?.0)
    }

    fn direction(&self) -> Checked<DVec3> {
        range::direction(&self.key("direction"), self.needed("direction", self.file.direction)?.0)
    }

    fn edge(&self, name: &str, value: Option<Vector>) -> Checked<DVec3> {
        range::point(&self.key(name), self.needed(name, value)?.0)
    }

    fn whole(&self, name: &str, value: Option<i64>, usual: i64, least: i64, most: i64) -> Checked<u32> {
        let value = value.unwrap_or(usual);
        let accepted = u32::try_from(value).ok().filter(|_| (least..=most).contains(&value));
        accepted.ok_or_else(|| {
            let fault = Input::new("out of range").key(self.key(name)).found(value);
            fault.expected(format!("a whole number from {least} to {most}"))
        })
    }

    /// Both angles of a spot, in degrees.
    fn cone(&self) -> Checked<(f64, f64)> {
        let outer = self.needed("outer", self.file.outer)?;
        let outer = range::number(&self.key("outer"), outer, |x| (1.0..=90.0).contains(&x), "1 to 90 degrees")?;
        let inner = self.file.inner.unwrap_or(0.0);
        let most = 0.95 * outer;
        let expected = format!("0 to {most} degrees: at most 0.95 times outer, so that the edge is soft");
        Ok((range::number(&self.key("inner"), inner, |x| (0.0..=most).contains(&x), &expected)?, outer))
    }

    fn area(&self) -> Checked<Source> {
        let edge_u = self.edge("edge_u", self.file.edge_u)?;
        let edge_v = self.edge("edge_v", self.file.edge_v)?;
        let (long, wide) = (edge_u.length(), edge_v.length());
        if edge_u.cross(edge_v).length() <= 1e-9 * long * wide {
            let found = format!("edge_u of length {long}, edge_v of length {wide}, and no area between them");
            let fault = Input::new("the rectangle has no area").key(self.key("edge_v")).found(found);
            return Err(fault.expected("two edges of any length but zero that are not parallel"));
        }
        Ok(Source::Area {
            position: self.position()?,
            edge_u,
            edge_v,
            radiance: self.amount("radiance", self.file.radiance)?,
            two_sided: self.file.two_sided.unwrap_or(false),
            samples: self.whole("samples", self.file.samples, 4, 1, 64)?,
        })
    }

    fn environment(&self) -> Checked<Source> {
        let one = "exactly one of `image` and `radiance`";
        let factor = match self.file.intensity {
            Some(_) => self.amount("intensity", self.file.intensity)?,
            None => [1.0; 3],
        };
        let angle = self.file.rotation.unwrap_or(0.0);
        let rotation = range::number(&self.key("rotation"), angle, |x| x.abs() <= 3600.0, "-3600 to 3600 degrees")?;
        let sky = match (&self.file.image, self.file.radiance) {
            (Some(image), None) => Sky::of_image(image, factor, rotation),
            (None, Some(_)) => Sky::constant(self.amount("radiance", self.file.radiance)?, factor),
            (Some(_), Some(_)) => {
                let fault = Input::new("both an image and a radiance are given").key(self.key("radiance"));
                return Err(fault.expected(one));
            }
            (None, None) => {
                let fault = Input::new("neither an image nor a radiance is given");
                return Err(fault.key(self.key("image")).expected(one));
            }
        };
        Ok(Source::Environment { sky, occlusion: self.whole("occlusion", self.file.occlusion, 0, 0, 4096)? })
    }
}

impl Light {
    /// Checks `[[light]]` number `index` of the file. The image of an environment is not read yet.
    pub(in crate::scene) fn check(file: &LightFile, index: usize) -> Checked<Self> {
        let (kind, needed, allowed) = keys(file.kind);
        let accepted = [&["type"], needed, allowed].concat().join(", ");
        let reader = Reader { file, index, kind, accepted };
        let other = |name: &&str| !needed.contains(name) && !allowed.contains(name);
        if let Some(name) = file.given().into_iter().find(other) {
            let what = format!("{} light has no such key", article(kind));
            return Err(Input::new(what).key(reader.key(name)).expected(&reader.accepted));
        }
        let source = match file.kind {
            LightKind::Directional => Source::Directional {
                direction: reader.direction()?,
                irradiance: reader.amount("irradiance", file.irradiance)?,
            },
            LightKind::Point => {
                Source::Point { position: reader.position()?, intensity: reader.amount("intensity", file.intensity)? }
            }
            LightKind::Spot => {
                let (inner, outer) = reader.cone()?;
                let (position, direction) = (reader.position()?, reader.direction()?);
                let intensity = reader.amount("intensity", file.intensity)?;
                Source::Spot { position, direction, intensity, inner, outer }
            }
            LightKind::Area => reader.area()?,
            LightKind::Environment => reader.environment()?,
        };
        Ok(Self { source, shadows: file.shadows.unwrap_or(true) })
    }

    /// Checks that no part of the light is inside a closed object that light enters, or that has layers, unless the
    /// object is two-sided.
    pub(in crate::scene) fn check_outside(&self, objects: &[Object], index: usize) -> Checked<()> {
        let lets_in = |object: &&Object| {
            let material = &object.material;
            !material.two_sided && (material.opaque.is_none() || material.layers.is_some())
        };
        let inside = |object: &Object| {
            let (places, own) = (self.places(), |place: &DVec3| object.unplaced(*place));
            let found = object.mesh.first_inside(&places.iter().map(own).collect::<Vec<_>>())?;
            let place = places.into_iter().find(|place| own(place) == found)?;
            Some((place, object.material.opaque.is_some()))
        };
        let Some((place, alone)) = objects.iter().filter(lets_in).find_map(inside) else { return Ok(()) };
        let fault = Input::new("the light stands in the medium").key(format!("light.{index}.position"));
        let expected = match alone {
            true => "a place outside the object or in a cavity of it",
            false => "a place outside the object or in a cavity of it, or two_sided = true in its material",
        };
        Err(fault.found(format!("a light at [{}, {}, {}]", place.x, place.y, place.z)).expected(expected))
    }

    /// Checks what holds for all lights of a scene together.
    pub(in crate::scene) fn check_all(lights: &[Self]) -> Checked<()> {
        let samples: usize = lights.iter().map(Self::samples).sum();
        if samples > Self::MOST_SAMPLES {
            let fault = Input::new("too many samples of all lights together").key("light").found(samples);
            let expected = format!(
                "at most {}: one a light, samples squared an area, occlusion an environment",
                Self::MOST_SAMPLES
            );
            return Err(fault.expected(expected));
        }
        let is_sky = |light: &Self| matches!(light.source, Source::Environment { .. });
        if let Some(second) = lights.iter().enumerate().filter(|(_, light)| is_sky(light)).map(|(i, _)| i).nth(1) {
            let fault = Input::new("a second environment").key(format!("light.{second}.type"));
            return Err(fault.expected("at most one light of type environment"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(text: &str) -> Result<Light, String> {
        let file: LightFile = toml::from_str(text).map_err(|e| e.message().to_string())?;
        Light::check(&file, 1).map_err(|e| e.to_string())
    }

    #[test]
    fn reads_every_kind() {
        let sun = light("type = 'directional'\ndirection = [0, 0, 5]\nirradiance = 2");
        assert_eq!(sun, Ok(Light::directional(DVec3::Z, [2.0; 3])));
        let lamp = light("type = 'point'\nposition = [1, 2, 3]\nintensity = [1, 0.5, 0]\nshadows = false");
        let expected = Light { shadows: false, ..Light::point(DVec3::new(1.0, 2.0, 3.0), [1.0, 0.5, 0.0]) };
        assert_eq!(lamp, Ok(expected));
        let spot = light("type = 'spot'\nposition = [0, 0, 1]\ndirection = [0, -2, 0]\nintensity = 1\nouter = 20");
        let spot = spot.map(|light| light.source);
        let (position, direction, intensity) = (DVec3::Z, -DVec3::Y, [1.0; 3]);
        assert_eq!(spot, Ok(Source::Spot { position, direction, intensity, inner: 0.0, outer: 20.0 }));
        let area = light("type = 'area'\nposition = [0, 0, 1]\nedge_u = [2, 0, 0]\nedge_v = [0, 4, 0]\nradiance = 1");
        let places = area.map(|light| light.places()).unwrap_or_default();
        assert_eq!((places.len(), places[0]), (16, DVec3::new(-0.75, -1.5, 1.0)));
    }

    #[test]
    fn names_the_key_at_fault() {
        let spot = "type = 'spot'\nposition = [0, 0, 1]\nintensity = 1\n";
        let area = "type = 'area'\nposition = [0, 0, 1]\nradiance = 1\nedge_u = [2, 0, 0]\n";
        let cases = [
            ("type = 'point'\nintensity = 1".into(), "light.1.position: missing: a point light needs it"),
            (
                "type = 'directional'\nintensity = 1".into(),
                "light.1.intensity: a directional light has no such key; \
                 expected type, direction, irradiance, shadows",
            ),
            (
                "type = 'point'\nposition = [0, 0, 1]\nintensity = [1, -2, 3]".into(),
                "light.1.intensity: out of range; found [1, -2, 3]; expected numbers from 0 to 1e30",
            ),
            ("type = 'sport'".into(), "unknown variant `sport`, expected one of `directional`, `point`, `spot`"),
            (format!("{spot}direction = [0, 0, 0]\nouter = 9"), "light.1.direction: a direction of length zero"),
            (format!("{spot}direction = [0, 0, 1]"), "light.1.outer: missing: a spot light needs it"),
            (
                format!("{spot}direction = [0, 0, 1]\nouter = 91"),
                "light.1.outer: out of range; found 91; expected 1 to 90",
            ),
            (
                format!("{spot}direction = [0, 0, 1]\nouter = 20\ninner = 30"),
                "light.1.inner: out of range; found 30; expected 0 to 19 degrees",
            ),
            (
                format!("{area}edge_v = [0, 0, 0]"),
                "light.1.edge_v: the rectangle has no area; found edge_u of length 2",
            ),
            (format!("{area}edge_v = [5, 0, 0]"), "light.1.edge_v: the rectangle has no area"),
            (
                format!("{area}edge_v = [0, 1, 0]\nsamples = 0"),
                "light.1.samples: out of range; found 0; expected a whole number from 1 to 64",
            ),
            ("type = 'environment'".into(), "light.1.image: neither an image nor a radiance is given"),
            ("type = 'environment'\nimage = 'a.exr'\nradiance = 1".into(), "light.1.radiance: both an image and"),
            ("type = 'environment'\nradiance = -1".into(), "light.1.radiance: out of range; found [-1, -1, -1]"),
            ("type = 'environment'\nradiance = 1\nshadows = true".into(), "light.1.shadows: an environment light"),
        ];
        for (text, message) in cases {
            let error = light(&text).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
