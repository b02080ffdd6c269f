//! Checks that deformed objects stay where `f32` is fine enough.

use glam::DVec3;

use super::shape::moved;
use super::units::Units;
use crate::error::{Input, Result};
use crate::scene::{Deform, Object};

/// How far vertices may move from the centre of the scene at rest, internal units: the scene at rest is at most 1
/// across.
const FARTHEST: f64 = 1.0;

/// An upper bound on how far an object's vertices get from its middle, internal units.
fn farthest(object: &Object, units: Units) -> f64 {
    let (low, high) = object.mesh.bounds();
    let half = 0.5 * (high - low).length();
    let bound = object.deforms.iter().fold(half, |radius, deform| match deform {
        // About a point of the axis, distances stay.
        Deform::Twist { span, .. } => 2.0 * (span.center - units.center).length() + radius,
        Deform::Bend { span, angle, .. } => {
            // Along the bent axis, then straight on beyond its ends, then across.
            let away = (span.center - units.center).length();
            let (most, turn) = (away + radius, span.length / angle);
            let along = |k: u32| {
                let (sine, cosine) = (angle * f64::from(k) / 64.0).sin_cos();
                (span.low + turn * sine).hypot(turn * (1.0 - cosine)) + span.length / 128.0
            };
            let bent = (0..=64).map(along).fold(0.0, f64::max);
            let beyond = (most - span.low - span.length).max(most + span.low).max(0.0);
            away + bent + beyond + most
        }
        Deform::Bump { height, .. } => radius + height.abs(),
        // Noise is -1 to 1 but for rounding.
        Deform::Noise { amplitude, .. } => radius + 1.001 * amplitude.abs(),
        // Joints may carry vertices anywhere.
        Deform::Skin { .. } => f64::INFINITY,
        Deform::Morph { ways, weight } => {
            radius + weight.abs() * ways.iter().map(|way| way.length_squared()).fold(0.0, f64::max).sqrt()
        }
    });
    1.001 * bound * units.length
}

/// The largest distance of the scene from the origin of noise, in cells: there `f32` still distinguishes 256
/// positions per cell.
const MOST_CELLS: f64 = 65_536.0;

/// Checks that deformed objects stay where distances are within the tables of distances and `f32` is fine enough. The
/// vertices are looked at where a bound on how far they move does not tell.
pub fn reach(objects: &[Object], units: Units) -> Result<()> {
    for (number, object) in objects.iter().enumerate() {
        let local = units.own(object);
        let place = |p: DVec3| object.placed(local.outside(p));
        let vertices = object.mesh.positions.len();
        let other = |deform: &Deform| match deform {
            Deform::Morph { ways, .. } => ways.len() != vertices,
            Deform::Skin { rig, .. } => rig.base.len() != vertices,
            _ => false,
        };
        if object.deforms.iter().any(other) {
            let fault = Input::new("a morph or skin is of another mesh").key(format!("object.{number}.deform"));
            return Err(fault.expected(format!("one entry for each of {vertices} vertices")).into());
        }
        for deform in &object.deforms {
            if let Deform::Noise { scale, offset, .. } = deform {
                let cells = ((*offset - local.center).abs().max_element() + 0.5 / units.length) / scale;
                if cells > MOST_CELLS {
                    let fault = Input::new("noise so fine, or offset so far, is no noise any more");
                    let expected = format!("the scene and `offset` within {MOST_CELLS} times `scale`");
                    let found = format!("{cells:.4e} times");
                    return Err(fault.key(format!("object.{number}.deform")).found(found).expected(expected).into());
                }
            }
        }
        let beyond = |p: &&DVec3| !p.is_finite() || units.inside(place(**p)).abs().max_element() > FARTHEST;
        let near = object.placed(local.outside(DVec3::ZERO));
        let within = farthest(object, local) + units.inside(near).abs().max_element() < FARTHEST;
        let moved = if within { None } else { moved(object, units) };
        if let Some(p) = moved.iter().flatten().find(beyond) {
            let found = format!("a vertex at {:.4}", place(*p));
            let most = FARTHEST / units.length;
            let expected =
                format!("within {most} of {:.4}, the middle of the scene at rest, on every axis", units.center);
            let fault = Input::new("the deformations move the object too far");
            return Err(fault.key(format!("object.{number}.deform")).found(found).expected(expected).into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn no_vertex_gets_farther_than_the_bound() {
        let deforms = [
            "{ type='twist', angle=170 }",
            "{ type='twist', angle=90, axis=[1, 1, 0], center=[9, -4, 2] }",
            "{ type='bend', angle=200, axis=[1, 0, 0], length=4 }",
            "{ type='bend', angle=-35, center=[0, 30, 0] }",
            "{ type='noise', amplitude=3, scale=4 }",
            "{ type='bump', position=[0, 0, 10], radius=12, height=-7 }",
        ];
        for first in deforms {
            for second in deforms {
                let deform = format!("object.0.deform=[{first}, {second}]");
                let sets = ["object.0.detail=3".into(), "object.0.position=[3, 0, 0]".into(), deform];
                let scene = Scene::load_with("sphere", &sets).unwrap();
                let (object, units) = (&scene.objects[0], Units::of(&scene.objects));
                let own = units.own(object);
                let all = moved(object, units).unwrap();
                let most = all.iter().map(|p| p.length()).fold(0.0, f64::max);
                let bound = farthest(object, own);
                // A ball twisted in itself stays where it is: nobody looks at its vertices.
                assert!(bound < FARTHEST || first != deforms[0] || second != deforms[0], "{bound}");
                assert!(most <= bound && bound < 100.0 * most, "{first} {second}: {most} {bound}");
            }
        }
    }
}
