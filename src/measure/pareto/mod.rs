//! Error against run time: every method at a range of settings, on one scene and one device, in one run.
//!
//! A method is one entry of [`METHODS`] and one function that opens it. Each setting is timed under two kinds of
//! lighting: a light that changes every frame, so that everything that depends on light runs again, and a constant
//! one, so that only the summation does. The error belongs to the timed frames themselves and is given against two
//! references: brute force over the method's own leaf sums, and the area integral over the same faces; for diffusion,
//! which is another equation, against its own solution.

mod frames;
mod front;
mod method;
mod pace;
mod plot;
mod ratios;
mod sheet;
mod sweep;
mod yardstick;

pub use front::{Against, front, mark};
pub use method::{Bench, METHODS, Method, Opened, Solver};
pub use plot::svg;
pub use ratios::{Norm, Ratio, Reach, ratios, time_at};
pub use sheet::{Origin, csv};
pub use sweep::{Settings, sweep};
pub use yardstick::{Equation, Leaves, Yardstick};

use super::norms::Norms;
use super::truth::TruthError;
use crate::pipeline::plan::{Goal, Options, ShadingMethod};
use crate::scene::Scene;

/// What the light does between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// It moves: irradiance and everything that depends on it run again.
    Moves,
    /// It rests: irradiance and what was prepared from it are kept, only the summation runs again.
    Rests,
}

impl Lighting {
    /// Both, in the order of every table.
    pub const ALL: [Self; 2] = [Self::Moves, Self::Rests];

    /// The lighting in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moves => "light moves",
            Self::Rests => "light rests",
        }
    }
}

/// Measurements of a method at one setting under one lighting.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Median time by device timestamps, milliseconds; `None` on the CPU, on a queue without timestamps, and for the
    /// octree, which runs on the host.
    pub device_ms: Option<f64>,
    /// Median wall-clock time of the whole frame, recording and waiting included, milliseconds.
    pub wall_ms: f64,
    /// Fastest and slowest frame, wall clock, milliseconds.
    pub range_ms: [f64; 2],
    /// Load of the machine by other work: the time of a fixed small job just before or after, the larger of both,
    /// over its fastest time in the run; at least 1.
    pub busy: f64,
    /// Error against brute force in `f64` over the method's own leaf sums, worst channel; of diffusion, against its
    /// solution on the CPU at a tenth of the finest tolerance.
    pub own: Norms,
    /// Error against the area integral over the same faces, in `f64`, worst channel; unknown for diffusion.
    pub total: Norms,
    /// Error against a walk, if one was asked for.
    pub truth: Option<TruthError>,
    /// Links summed, per face; `None` if the method has no links.
    pub links_per_face: Option<f64>,
}

/// One setting of one method under one lighting.
#[derive(Clone, Debug)]
pub struct Point {
    /// The method.
    pub method: &'static Method,
    /// Its setting, in the method's own unit; unused if it has none.
    pub value: f64,
    /// The lighting.
    pub lighting: Lighting,
    /// The measurements, or the reason why there are none.
    pub run: Result<Run, String>,
}

impl Point {
    /// The setting in words; empty where the method has none.
    pub fn setting(&self) -> String {
        if self.method.parameter.is_empty() {
            String::new()
        } else {
            format!("{} {}", self.method.parameter, self.value)
        }
    }
}

/// All measurements of one run of the program.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The points by method, then from coarse to fine, for each setting first with the moving light.
    pub points: Vec<Point>,
    /// Number of receivers at which errors are measured.
    pub samples: usize,
    /// Error of plain midpoint sums, without any clustering, against the area integral, worst channel.
    pub midpoint: Norms,
    /// The walk that points are compared with as well, in words.
    pub truth: Option<String>,
}

impl Sweep {
    /// The measured points under one lighting.
    pub fn measured(&self, lighting: Lighting) -> impl Iterator<Item = (&Point, &Run)> {
        let here = self.points.iter().filter(move |point| point.lighting == lighting);
        here.filter_map(|point| point.run.as_ref().ok().map(|run| (point, run)))
    }

    /// This sweep with the points of another one, of replaced kernels, behind its own; `how` goes to the names of the
    /// other one's methods.
    #[must_use]
    pub fn beside(mut self, other: Self, how: &str) -> Self {
        let called = |point: Point| Point { method: point.method.called(how), ..point };
        self.points.extend(other.points.into_iter().map(called));
        self
    }

    /// The methods that have points, in order.
    pub fn methods(&self) -> Vec<&'static Method> {
        let mut methods: Vec<&'static Method> = Vec::new();
        for point in &self.points {
            if !methods.iter().any(|known| known.name == point.method.name) {
                methods.push(point.method);
            }
        }
        methods
    }

    /// The references to report: one of the two if every method integrates over its leaves, since they are equal then.
    pub fn yardsticks(&self) -> &'static [Against] {
        let exact = self.methods().iter().all(|method| method.leaves == Leaves::Exact);
        if exact { &[Against::Own] } else { &[Against::Own, Against::Total] }
    }

    /// The references to plot: those, and the walk.
    pub fn plotted(&self) -> Vec<Against> {
        self.yardsticks().iter().copied().chain(self.truth.is_some().then_some(Against::Truth)).collect()
    }
}

/// The scene and options of diffusion at a tolerance.
fn diffusion_at(scene: &Scene, tolerance: f64) -> (Scene, Options) {
    let mut scene = scene.clone();
    scene.transport.tolerance = tolerance;
    (scene, Options { transport: ShadingMethod::Diffusion, goal: Goal::Radiosity, ..Options::default() })
}
