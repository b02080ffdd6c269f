//! The error of a frame in one number a channel, from its error estimate.

use super::run::Session;
use crate::error::Result;
use crate::layout::BufferId;
use crate::state::Object;

impl Session {
    /// The estimated error of the last frame's radiosity, r g b: sqrt(sum A e^2 / sum A B^2) over the triangles of
    /// translucent objects, 0 in a channel without light. None where no error is estimated; objects whose receivers are
    /// pixels are left out.
    ///
    /// This is the estimate of the frame itself, which adds up the errors of links as if none cancelled; after
    /// [`Session::sharpen`] it is the refined one.
    pub fn estimated_error(&mut self) -> Result<Option<[f64; 3]>> {
        if !self.state().method.estimate {
            return Ok(None);
        }
        self.fetch(&[BufferId::radiosity, BufferId::estimate])?;
        let (state, data) = (self.state(), &self.state().data);
        let (mut missed, mut power) = ([0.0; 3], [0.0; 3]);
        let at_faces = |object: &Object| !object.opaque && !object.by_pixel;
        for (number, object) in state.objects.iter().enumerate().filter(|(_, object)| at_faces(object)) {
            for (local, area) in self.areas(number).into_iter().enumerate() {
                let receiver = object.first.receivers + local;
                let beside = self.missed(object.first.faces + local);
                for c in 0..3 {
                    missed[c] += area * f64::from(data.estimate[receiver][c]).hypot(beside[c]).powi(2);
                    power[c] += area * f64::from(data.radiosity[receiver][c]).powi(2);
                }
            }
        }
        Ok(Some([0, 1, 2].map(|c| if power[c] > 0.0 { (missed[c] / power[c]).sqrt() } else { 0.0 })))
    }

    /// The areas of an object's triangles, in the order of its receivers.
    fn areas(&self, object: usize) -> Vec<f64> {
        let vertices = self.own_vertices(object);
        let triangles = &self.scene().objects[object].mesh.triangles;
        let first = self.state().objects[object].first.faces;
        let mut areas = vec![0.0; triangles.len()];
        for (triangle, place) in triangles.iter().zip(self.prepared().places(object)) {
            let [a, b, c] = triangle.map(|v| vertices[v as usize]);
            areas[place - first] = 0.5 * (b - a).cross(c - a).length();
        }
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::plan::{Change, Goal, Options};
    use crate::scene::Scene;

    #[test]
    fn it_is_the_norm_of_the_estimates_of_faces() {
        let sets = ["object.0.detail=3".to_string(), "transport.tolerance=0.05".to_string()];
        let scene = Scene::load_with("sphere", &sets).unwrap();
        let options = Options { goal: Goal::Radiosity, estimate: true, ..Options::default() };
        let mut session = Session::new(&scene, None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let raw = session.estimated_error().unwrap().unwrap();
        session.sharpen().unwrap();
        let refined = session.estimated_error().unwrap().unwrap();
        let faces = session.faces().unwrap();
        for c in 0..3 {
            let sum =
                |of: &dyn Fn(usize) -> f64| -> f64 { (0..faces.len()).map(|k| faces[k].area * of(k).powi(2)).sum() };
            let norm = (sum(&|k| faces[k].estimate.unwrap()[c]) / sum(&|k| faces[k].radiosity[c])).sqrt();
            assert!((refined[c] / norm - 1.0).abs() < 1e-9 && refined[c] > 0.0, "{refined:?}, channel {c}: {norm}");
            assert!(refined[c] < raw[c] && refined[c] < 0.05, "{refined:?} of {raw:?}");
        }

        // Without an estimate there is none.
        let mut session = Session::new(&scene, None, Options { estimate: false, ..options }).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        assert_eq!(session.estimated_error().unwrap(), None);
    }
}
