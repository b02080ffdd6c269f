//! Error against run time: every method over its sweep of settings, on one scene and one device, in one run.
//!
//! A method is one entry of [`METHODS`] and one function that opens it. Each of its settings is timed twice over:
//! under a light that moves every frame, so that all that depends on light runs, and under one that rests, so that
//! only the summing runs. Beside each time stands the error of the very frames that were timed, twice too: against
//! brute force over the method's own leaf sums, and against the area integral over the same faces.

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
pub(in crate::measure) use plot::COLORS;
pub use plot::svg;
pub use ratios::{Norm, Ratio, Reach, ratios, time_at};
pub use sheet::{Origin, csv};
pub use sweep::{Settings, sweep};
pub use yardstick::{Leaves, Yardstick};

use super::norms::Norms;

/// What the light does from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// It moves: irradiance and all that depends on it run again.
    Moves,
    /// It rests, and with it irradiance and what was prepared from it: only what sums it up runs again.
    Rests,
}

impl Lighting {
    /// Both, in the order of every table.
    pub const ALL: [Self; 2] = [Self::Moves, Self::Rests];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moves => "light moves",
            Self::Rests => "light rests",
        }
    }
}

/// What was measured of a method at one setting under one lighting.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Median time on the device by its timestamps, milliseconds; none on the CPU, where a queue has none, and of
    /// the octree, which runs on the host.
    pub device_ms: Option<f64>,
    /// Median wall-clock time of the whole frame, recording and waiting included, milliseconds.
    pub wall_ms: f64,
    /// Fastest and slowest frame, wall clock, milliseconds.
    pub range_ms: [f64; 2],
    /// How busy the machine was with something else: the time of a fixed small job just before or after, the worse,
    /// as a multiple of its fastest in the run; at least 1.
    pub busy: f64,
    /// Error against brute force in `f64` over the method's own leaf sums, worst channel.
    pub own: Norms,
    /// Error against the area integral over the same faces, in `f64`, worst channel.
    pub total: Norms,
    /// Links summed, per face; none where the method has no links.
    pub links_per_face: Option<f64>,
}

/// One setting of one method under one lighting.
#[derive(Clone, Debug)]
pub struct Point {
    /// The method.
    pub method: &'static Method,
    /// Its setting, in the method's own unit; of no meaning where it has none.
    pub value: f64,
    /// What the light did.
    pub lighting: Lighting,
    /// What was measured, or why nothing was.
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

/// All that one run of the program has measured.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The points: method after method, each from coarse to fine, at every setting the light moving first.
    pub points: Vec<Point>,
    /// Receivers that errors were taken at.
    pub samples: usize,
    /// Error of plain midpoint sums, without any clustering, against the area integral, worst channel.
    pub midpoint: Norms,
}

impl Sweep {
    /// The measured points under one lighting.
    pub fn measured(&self, lighting: Lighting) -> impl Iterator<Item = (&Point, &Run)> {
        let here = self.points.iter().filter(move |point| point.lighting == lighting);
        here.filter_map(|point| point.run.as_ref().ok().map(|run| (point, run)))
    }

    /// The methods that have points, in their order.
    pub fn methods(&self) -> Vec<&'static Method> {
        let mut methods: Vec<&'static Method> = Vec::new();
        for point in &self.points {
            if !methods.iter().any(|known| known.name == point.method.name) {
                methods.push(point.method);
            }
        }
        methods
    }

    /// The yardsticks that differ: where every method integrates over its leaves, both are one.
    pub fn yardsticks(&self) -> &'static [Against] {
        let exact = self.methods().iter().all(|method| method.leaves == Leaves::Exact);
        if exact { &[Against::Own] } else { &[Against::Own, Against::Total] }
    }
}
