//! The lights of a scene. Directions point towards the light; none of them casts shadows yet.

use super::file::{LightFile, LightKind};
use super::range::{self, Checked};
use super::vector::Rgb;
use crate::error::Input;
use glam::DVec3;

/// A light, checked: every number finite, every amount at least 0.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// A light infinitely far away, such as the sun.
    Directional {
        /// Towards the light, length 1.
        direction: DVec3,
        /// Irradiance on a plane perpendicular to the direction, r g b, at least 0.
        irradiance: [f64; 3],
    },
    /// A light at a point, the same in all directions.
    Point {
        /// Where it is, in scene units.
        position: DVec3,
        /// Intensity in W/sr, r g b, at least 0; falls off with the squared distance in scene units.
        intensity: [f64; 3],
    },
}

impl Light {
    /// Checks `[[light]]` number `index` of the file.
    pub(super) fn check(file: &LightFile, index: usize) -> Checked<Self> {
        let key = |name: &str| format!("light.{index}.{name}");
        let given = [
            ("direction", file.direction.is_some()),
            ("irradiance", file.irradiance.is_some()),
            ("position", file.position.is_some()),
            ("intensity", file.intensity.is_some()),
        ];
        let (kind, wanted) = match file.kind {
            LightKind::Directional => ("directional", ["direction", "irradiance"]),
            LightKind::Point => ("point", ["position", "intensity"]),
        };
        let accepted = format!("type, {}, {}", wanted[0], wanted[1]);
        if let Some((name, _)) = given.iter().find(|(name, set)| *set && !wanted.contains(name)) {
            let what = format!("a {kind} light has no such key");
            return Err(Input::new(what).key(key(name)).expected(accepted));
        }
        let missing = |name: &str| {
            let what = format!("missing: a {kind} light needs it");
            Input::new(what).key(key(name)).expected(&accepted)
        };
        let amount = |name: &str, value: Option<Rgb>| {
            let value = value.ok_or_else(|| missing(name))?.0;
            range::channels(&key(name), value, |x| (0.0..=1e30).contains(&x), "numbers from 0 to 1e30")
        };
        match file.kind {
            LightKind::Directional => {
                let direction = file.direction.ok_or_else(|| missing("direction"))?.0;
                Ok(Self::Directional {
                    direction: range::direction(&key("direction"), direction)?,
                    irradiance: amount("irradiance", file.irradiance)?,
                })
            }
            LightKind::Point => {
                let position = file.position.ok_or_else(|| missing("position"))?.0;
                Ok(Self::Point {
                    position: range::point(&key("position"), position)?,
                    intensity: amount("intensity", file.intensity)?,
                })
            }
        }
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
    fn reads_both_kinds() {
        let sun = light("type = 'directional'\ndirection = [0, 0, 5]\nirradiance = 2");
        let expected = Light::Directional { direction: DVec3::Z, irradiance: [2.0; 3] };
        assert_eq!(sun, Ok(expected));
        let lamp = light("type = 'point'\nposition = [1, 2, 3]\nintensity = [1, 0.5, 0]");
        let position = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(lamp, Ok(Light::Point { position, intensity: [1.0, 0.5, 0.0] }));
    }

    #[test]
    fn names_the_key_at_fault() {
        let cases = [
            ("type = 'point'\nintensity = 1", "light.1.position: missing: a point light needs it"),
            (
                "type = 'directional'\nintensity = 1",
                "light.1.intensity: a directional light has no such key; \
                 expected type, direction, irradiance",
            ),
            (
                "type = 'point'\nposition = [0, 0, 1]\nintensity = [1, -2, 3]",
                "light.1.intensity: out of range; found [1, -2, 3]; expected numbers from 0 to 1e30",
            ),
            ("type = 'spot'", "unknown variant `spot`, expected `directional` or `point`"),
        ];
        for (text, message) in cases {
            let error = light(text).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
