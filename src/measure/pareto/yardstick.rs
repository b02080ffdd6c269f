//! The reference of errors: sums over all faces in `f64` at a few seeded receivers.

use rayon::prelude::*;

use super::{Method, diffusion_at};
use crate::dipole::form_factor::Distance as Sources;
use crate::dipole::form_factor::points::sampled;
use crate::dipole::profile::Dipole;
use crate::error::{Input, Result};
use crate::measure::norms::{Norms, norms, worst};
use crate::measure::reference::{by_object, radiosity, receivers};
use crate::measure::sample::Sample;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::{Hierarchy, Near, Scene, Scheme};
use crate::session::choice::closed;
use crate::session::run::Session;
use crate::state::{Distance, State, wide};

/// The equation that a method solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equation {
    /// The sum of every triangle's dipole.
    Dipole,
    /// Diffusion on the object's own surface.
    Diffusion,
}

/// How a method treats a single triangle at its finest level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaves {
    /// One sample at its centroid, times its area.
    Midpoint,
    /// The integral over its area, within the form factor's tolerance.
    Exact,
}

impl Leaves {
    /// The name in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Midpoint => "midpoint",
            Self::Exact => "integral",
        }
    }
}

/// The rule with one sample at the centroid.
const CENTER: [[f64; 4]; 1] = [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 1.0]];

/// Brute force at a sample of receivers, in the scene's units.
pub struct Yardstick {
    /// The receivers, by face of the state that guided the sampling.
    sample: Sample,
    /// The receivers' triangles, numbered through all meshes.
    faces: Vec<usize>,
    exact: Vec<[f64; 3]>,
    midpoint: Vec<[f64; 3]>,
    diffusion: Option<Vec<[f64; 3]>>,
}

impl Yardstick {
    /// Reference values for `count` seeded faces of a scene; a scene without light is an error.
    pub fn new(scene: &Scene, count: usize, seed: u64) -> Result<Self> {
        let options = Options { transport: ShadingMethod::Brute, goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(scene, None, options)?;
        if !session.state().lit() {
            let fault = Input::new("no light shines, so there is no error to measure").key("light");
            return Err(fault.expected("at least one [[light]] that is not black").into());
        }
        // A rough solution by the usual method guides the sampling, whatever the scene's settings.
        let mut rough = scene.clone();
        let usual = (Scheme::Blocks, Hierarchy::Median, Distance::Radial, Near::Exact);
        let keys = &mut rough.transport;
        (keys.scheme, keys.hierarchy, keys.distance, keys.near) = usual;
        let options = Options { goal: Goal::Radiosity, ..Options::default() };
        let mut rough = Session::new(&rough, None, options)?;
        rough.frame(Change::EVERYTHING)?;
        let sample = receivers(rough.state(), count, seed);

        // Irradiance by the CPU reference, as the input of the sums.
        session.prepare_light();
        let places: Vec<usize> = session.prepared().all_places().collect();
        let mut number = vec![0; rough.state().extent().faces];
        rough.prepared().all_places().enumerate().for_each(|(face, place)| number[place] = face);
        let faces: Vec<usize> = sample.faces.iter().map(|&place| number[place]).collect();
        let places: Vec<usize> = faces.iter().map(|&face| places[face]).collect();
        let (state, light) = (session.state(), session.units().light);
        let scaled = |sums: Vec<[f64; 3]>| sums.into_iter().map(|sum| sum.map(|x| x * light)).collect();
        Ok(Self {
            exact: scaled(radiosity(state, &places)),
            midpoint: scaled(midpoint(state, &places)),
            sample,
            faces,
            diffusion: None,
        })
    }

    /// Adds the solution of the diffusion equation, on the CPU at a tenth of this tolerance; adds nothing without a
    /// tolerance, or where a mesh is open.
    pub fn with_diffusion(mut self, scene: &Scene, finest: Option<f64>) -> Result<Self> {
        let (Some(finest), Ok(())) = (finest, closed(scene)) else { return Ok(self) };
        let (scene, options) = diffusion_at(scene, 0.1 * finest);
        let mut session = Session::new(&scene, None, options)?;
        session.frame(Change::EVERYTHING)?;
        let all: Vec<[f64; 3]> = session.faces()?.into_iter().map(|face| face.radiosity).collect();
        self.diffusion = Some(self.faces.iter().map(|&face| all[face]).collect());
        Ok(self)
    }

    /// The number of receivers.
    pub fn samples(&self) -> usize {
        self.faces.len()
    }

    /// The errors, worst channel, of the radiosity of all triangles: against the method's own leaf sums, and against
    /// the area integral; of diffusion, only against its own solution.
    pub fn errors(&self, method: &Method, radiosity: &[[f64; 3]]) -> [Norms; 2] {
        let values: Vec<[f64; 3]> = self.faces.iter().map(|&face| radiosity[face]).collect();
        if method.equation == Equation::Diffusion {
            let own = self.diffusion.as_ref().map_or(Norms::UNKNOWN, |own| worst(&norms(&self.sample, &values, own)));
            return [own, Norms::UNKNOWN];
        }
        [method.leaves, Leaves::Exact].map(|leaves| worst(&norms(&self.sample, &values, self.sums(leaves))))
    }

    /// The error of such leaf sums without clustering against the area integral, worst channel.
    pub fn discretisation(&self, leaves: Leaves) -> Norms {
        worst(&norms(&self.sample, self.sums(leaves), &self.exact))
    }

    fn sums(&self, leaves: Leaves) -> &[[f64; 3]] {
        match leaves {
            Leaves::Midpoint => &self.midpoint,
            Leaves::Exact => &self.exact,
        }
    }
}

/// Radiosity at the centroids of these faces by one sample per face, in `f64`.
fn midpoint(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    by_object(state, faces, midpoint_alone)
}

fn midpoint_alone(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    let data = &state.data;
    let dipoles = [0, 1, 2].map(|channel| Dipole::of(&data.object_params[0], channel));
    let distance = match state.distance {
        Distance::Radial => Sources::Radial,
        Distance::Table1 => Sources::Table1 { clamp: true },
    };
    let corners = |face: usize| data.triangles[face].map(|v| wide(data.positions[v as usize]));
    let at_receiver = |&receiver: &usize| {
        let [a, b, c] = corners(receiver);
        let x = (a + b + c) / 3.0;
        let mut sum = [0.0; 3];
        for (face, light) in data.irradiance.iter().enumerate().filter(|(_, light)| **light != [0.0; 3]) {
            let corners = corners(face);
            for (channel, dipole) in dipoles.iter().enumerate() {
                sum[channel] += f64::from(light[channel]) * sampled(&corners, x, dipole, distance, &CENTER);
            }
        }
        sum
    };
    faces.par_iter().map(at_receiver).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The L2 error of midpoint sums on the built-in ball at this size, millimetres.
    fn midpoint_error(size: &str) -> f64 {
        let sets = ["object.0.detail=2".to_string(), format!("object.0.size={size}")];
        let scene = Scene::load_with("sphere", &sets).unwrap();
        Yardstick::new(&scene, 40, 1).unwrap().discretisation(Leaves::Midpoint).l2
    }

    #[test]
    fn midpoint_sums_are_good_where_faces_are_small_against_the_mean_free_path() {
        let (small, large) = (midpoint_error("0.5"), midpoint_error("50"));
        assert!(small < 1e-2 && large > 0.1, "{small} {large}");
    }

    #[test]
    fn a_dark_scene_is_refused() {
        let scene = Scene::load_with("sphere", &["light.0.irradiance=0".to_string(), "object.0.detail=0".to_string()]);
        assert!(Yardstick::new(&scene.unwrap(), 4, 1).is_err_and(|e| e.exit_code() == 2));
    }
}
