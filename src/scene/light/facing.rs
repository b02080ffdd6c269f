//! Where a light stands: outside the media of a scene's objects, and facing at least one of these.

use super::super::object::Object;
use super::super::range::Checked;
use super::{Light, Source};
use crate::error::Input;
use glam::DVec3;
use rayon::prelude::*;

impl Light {
    /// Checks that no part of the light is inside a closed object that light enters, or that has layers, unless the
    /// object is two-sided.
    pub(in crate::scene) fn check_outside(&self, objects: &[Object], index: usize) -> Checked<()> {
        let lets_in = |object: &&Object| {
            let material = &object.material;
            !material.two_sided && (material.opaque.is_none() || material.layers.is_some())
        };
        let inside = |object: &Object| {
            let (places, local) = (self.places(), |place: &DVec3| object.unplaced(*place));
            let found = object.mesh.first_inside(&places.iter().map(local).collect::<Vec<_>>())?;
            let place = places.into_iter().find(|place| local(place) == found)?;
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

    /// Why the light lights none of the objects, and what helps: all are outside the cone of a spot or behind an area
    /// light. `None` if it may light one, or if one deforms.
    pub(in crate::scene) fn misses(&self, objects: &[Object]) -> Option<&'static str> {
        if objects.iter().any(|object| !object.deforms.is_empty()) {
            return None;
        }
        let faces = |reached: &(dyn Fn(&[DVec3; 3]) -> bool + Sync)| {
            objects.iter().any(|object| {
                let corners = |face| Some(object.mesh.corners(face)?.map(|corner| object.placed(corner)));
                let faces = (0..object.mesh.triangles.len()).into_par_iter();
                faces.filter_map(corners).any(|corners| reached(&corners))
            })
        };
        match &self.source {
            Source::Spot { position, direction, outer, .. } => {
                // A triangle stands for the ball around it.
                let in_cone = |[a, b, c]: &[DVec3; 3]| {
                    let center = (*a + *b + *c) / 3.0;
                    let radius = [a, b, c].map(|p| p.distance(center)).into_iter().fold(0.0, f64::max);
                    let way = center - *position;
                    way.length() <= radius
                        || way.angle_between(*direction) <= outer.to_radians() + (radius / way.length()).asin()
                };
                (!faces(&in_cone))
                    .then_some("every object is outside its cone; target = [x, y, z] instead of direction aims it")
            }
            Source::Area { position, edge_u, edge_v, two_sided: false, .. } => {
                let normal = edge_u.cross(*edge_v);
                let in_front = |corners: &[DVec3; 3]| corners.iter().any(|&p| (p - *position).dot(normal) > 0.0);
                (!faces(&in_front)).then_some("every object is behind it: it shines to the side of edge_u x edge_v, and target = [x, y, z] turns it")
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Scene;

    /// What a scene says of its light.
    fn said(light: &str) -> Vec<String> {
        let sets = [format!("light.0={light}"), "object.0.size=20".into(), "object.0.detail=2".into()];
        Scene::load_with("sphere", &sets).unwrap().report
    }

    #[test]
    fn a_light_that_faces_no_object_says_so() {
        let spot = |aim: &str, outer: f64| {
            said(&format!("{{ type = 'spot', position = [0, 0, 50], {aim}, intensity = 1, outer = {outer} }}"))
        };
        let area = |more: &str| {
            let edges = "edge_u = [4, 0, 0], edge_v = [0, 4, 0]";
            said(&format!("{{ type = 'area', position = [0, 0, 50], {edges}, radiance = 1, samples = 1 {more} }}"))
        };
        // A spot just aside: the ball covers 11.5 degrees on each side of its middle.
        assert_eq!(spot("direction = [0, 0, -1]", 1.0), [""; 0]);
        assert_eq!(spot("direction = [0.25, 0, -1]", 5.0), [""; 0]);
        assert_eq!(spot("target = [0, 0, 9]", 1.0), [""; 0]);
        let missed = spot("direction = [0.6, 0, -1]", 5.0);
        assert_eq!(
            missed,
            [
                "light 0 lights nothing: every object is outside its cone; target = [x, y, z] instead of direction aims it"
            ],
            "{missed:?}"
        );
        assert!(area("").len() == 1 && area("")[0].contains("behind it"), "{:?}", area(""));
        for more in [", two_sided = true", ", target = [0, 0, 0]"] {
            assert_eq!(area(more), [""; 0], "{more}");
        }
    }
}
