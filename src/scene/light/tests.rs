//! Lights of scene files: every kind, and the key at fault.

use super::file::LightFile;
use super::{Light, Source};
use glam::DVec3;

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
    let aimed = "type = 'spot'\nposition = [0, 3, 1]\ntarget = [0, 1, 1]\nintensity = 1\nouter = 20";
    let aims = |light: Light| match light.source {
        Source::Spot { direction, .. } | Source::Directional { direction, .. } => direction,
        Source::Area { edge_u, edge_v, .. } => edge_u.cross(edge_v).normalize(),
        _ => DVec3::ZERO,
    };
    assert_eq!(light(aimed).map(aims), Ok(-DVec3::Y));
    let sun = light("type = 'directional'\nposition = [0, 3, 1]\ntarget = [0, 1, 1]\nirradiance = 1");
    assert_eq!(sun.map(aims), Ok(DVec3::Y));
    let panel = "type = 'area'\nposition = [0, 3, 1]\ntarget = [0, 1, 1]\nedge_u = [2, 0, 0]\nedge_v = [0, 2, 0]";
    assert!(light(&format!("{panel}\nradiance = 1")).map(aims).is_ok_and(|way| way.distance(-DVec3::Y) < 1e-12));
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
             expected type, irradiance, direction, position, target, shadows",
        ),
        (
            "type = 'point'\nposition = [0, 0, 1]\nintensity = [1, -2, 3]".into(),
            "light.1.intensity: out of range; found [1, -2, 3]; expected numbers from 0 to 1e30",
        ),
        ("type = 'sport'".into(), "unknown variant `sport`, expected one of `directional`, `point`, `spot`"),
        (format!("{spot}direction = [0, 0, 0]\nouter = 9"), "light.1.direction: a direction of length zero"),
        (format!("{spot}outer = 9"), "light.1.direction: missing: a spot light needs it, or a target"),
        (
            format!("{spot}direction = [0, 0, 1]\ntarget = [0, 0, 0]\nouter = 9"),
            "light.1.target: both a direction and a target are given",
        ),
        (format!("{spot}target = [0, 0, 1]\nouter = 9"), "light.1.target: the target is where the light is"),
        (
            "type = 'directional'\nposition = [0, 0, 1]\ndirection = [0, 0, 1]\nirradiance = 1".into(),
            "light.1.position: a light that is infinitely far away has no position",
        ),
        (format!("{spot}direction = [0, 0, 1]"), "light.1.outer: missing: a spot light needs it"),
        (format!("{spot}direction = [0, 0, 1]\nouter = 91"), "light.1.outer: out of range; found 91; expected 1 to 90"),
        (
            format!("{spot}direction = [0, 0, 1]\nouter = 20\ninner = 30"),
            "light.1.inner: out of range; found 30; expected 0 to 19 degrees",
        ),
        (format!("{area}edge_v = [0, 0, 0]"), "light.1.edge_v: the rectangle has no area; found edge_u of length 2"),
        (format!("{area}edge_v = [5, 0, 0]"), "light.1.edge_v: the rectangle has no area"),
        (
            format!("{area}edge_v = [0, 1, 0]\nsamples = 0"),
            "light.1.samples: out of range; found 0; expected a whole number from 1 to 64",
        ),
        ("type = 'environment'".into(), "light.1.image: neither an image nor a radiance is given"),
        (
            "type = 'environment'\nradiance = 1\nsun = true".into(),
            "light.1.sun: a sun is looked for in an image file only",
        ),
        (
            "type = 'environment'\nimage = 'builtin:sky'\nsun = false".into(),
            "light.1.sun: a sun is looked for in an image file only",
        ),
        ("type = 'environment'\nimage = 'a.exr'\nradiance = 1".into(), "light.1.radiance: both an image and"),
        ("type = 'environment'\nradiance = -1".into(), "light.1.radiance: out of range; found [-1, -1, -1]"),
        ("type = 'environment'\nradiance = 1\nshadows = true".into(), "light.1.shadows: an environment light"),
    ];
    for (text, message) in cases {
        let error = light(&text).err().unwrap_or_default();
        assert!(error.starts_with(message), "{error}");
    }
}
