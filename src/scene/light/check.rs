//! Turns `[[light]]` of the file into a validated light.

use super::super::range::{self, Checked};
use super::super::vector::{Rgb, Vector};
use super::file::{LightFile, LightKind};
use super::{Light, Sky, Source};
use crate::error::Input;
use glam::{DQuat, DVec3};

/// A kind's name, its required keys, and its optional keys besides `type`.
type Keys = (&'static str, &'static [&'static str], &'static [&'static str]);

fn keys(kind: LightKind) -> Keys {
    match kind {
        LightKind::Directional => ("directional", &["irradiance"], &["direction", "position", "target", "shadows"]),
        LightKind::Point => ("point", &["position", "intensity"], &["shadows"]),
        LightKind::Spot => ("spot", &["position", "intensity", "outer"], &["direction", "target", "inner", "shadows"]),
        LightKind::Area => {
            ("area", &["position", "edge_u", "edge_v", "radiance"], &["target", "two_sided", "samples", "shadows"])
        }
        LightKind::Environment => {
            ("environment", &[], &["image", "radiance", "intensity", "rotation", "occlusion", "sun"])
        }
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

    /// The direction from `position` to `target`, if there is a target.
    fn aim(&self) -> Checked<Option<DVec3>> {
        let Some(target) = self.file.target else { return Ok(None) };
        let (key, place) = (self.key("target"), self.position()?);
        let target = range::point(&key, target.0)?;
        if target == place {
            let fault = Input::new("the target is where the light is").key(key).found(format!("{target}"));
            return Err(fault.expected("another point"));
        }
        Ok(Some((target - place).normalize()))
    }

    /// The direction in which a spot shines.
    fn direction(&self) -> Checked<DVec3> {
        let accepted = "`direction`, or `target` and `position`";
        match (self.aim()?, self.file.direction) {
            (Some(aim), None) => Ok(aim),
            (None, Some(direction)) => range::direction(&self.key("direction"), direction.0),
            (Some(_), Some(_)) => {
                let fault = Input::new("both a direction and a target are given").key(self.key("target"));
                Err(fault.expected(accepted))
            }
            (None, None) => {
                let what = format!("missing: {} light needs it, or a target", article(self.kind));
                Err(Input::new(what).key(self.key("direction")).expected(accepted))
            }
        }
    }

    /// The direction towards a light that is infinitely far away.
    fn toward(&self) -> Checked<DVec3> {
        if self.file.position.is_some() && self.file.target.is_none() {
            let fault = Input::new("a light that is infinitely far away has no position").key(self.key("position"));
            return Err(fault.expected("no position, or a target as well: it then shines from the one to the other"));
        }
        let direction = self.direction()?;
        Ok(if self.file.target.is_some() { -direction } else { direction })
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
        // Turned by the smallest angle, so that it faces its target.
        let normal = (edge_u / long).cross(edge_v / wide).normalize();
        let turn = self.aim()?.map_or(DQuat::IDENTITY, |aim| DQuat::from_rotation_arc(normal, aim));
        Ok(Source::Area {
            position: self.position()?,
            edge_u: turn * edge_u,
            edge_v: turn * edge_v,
            radiance: self.amount("radiance", self.file.radiance)?,
            two_sided: self.file.two_sided.unwrap_or(false),
            samples: self.whole("samples", self.file.samples, 4, 1, 64)?,
        })
    }

    fn environment(&self) -> Checked<Source> {
        let accepted = "exactly one of `image` and `radiance`";
        let factor = match self.file.intensity {
            Some(_) => self.amount("intensity", self.file.intensity)?,
            None => [1.0; 3],
        };
        let angle = self.file.rotation.unwrap_or(0.0);
        let rotation = range::number(&self.key("rotation"), angle, |x| x.abs() <= 3600.0, "-3600 to 3600 degrees")?;
        let mut sky = match (&self.file.image, self.file.radiance) {
            (Some(image), None) => Sky::of_image(image, factor, rotation),
            (None, Some(_)) => Sky::constant(self.amount("radiance", self.file.radiance)?, factor),
            (Some(_), Some(_)) => {
                let fault = Input::new("both an image and a radiance are given").key(self.key("radiance"));
                return Err(fault.expected(accepted));
            }
            (None, None) => {
                let fault = Input::new("neither an image nor a radiance is given");
                return Err(fault.key(self.key("image")).expected(accepted));
            }
        };
        if self.file.sun.is_some() && !sky.is_read() {
            let fault = Input::new("a sun is looked for in an image file only").key(self.key("sun"));
            return Err(fault.expected("image = \"FILE.hdr\" beside it"));
        }
        sky.seeks_sun = self.file.sun.unwrap_or(true);
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
                direction: reader.toward()?,
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

    /// Checks how many samples all lights of a scene have together, and that at most one of them is an environment.
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
