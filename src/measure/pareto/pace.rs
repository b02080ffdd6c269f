//! Detects other load on the machine: a fixed small job, timed between points.
//!
//! A median does not show a slowdown of all frames of a point; the time of a fixed job does.

use std::time::Instant;

use super::method::brute;
use super::{Bench, Lighting, Opened, Solver};
use crate::error::Result;
use crate::gpu::Device;
use crate::scene::Scene;

/// Time limit for the larger job, seconds: it runs twice for each point.
const LONG: f64 = 0.1;

/// The job is brute force over a ball. On a device it has 1,280 faces if that is fast enough, otherwise 320; on the
/// CPU, whose reference is slow, 80.
pub struct Pace {
    solver: Option<Box<dyn Solver>>,
    fastest: f64,
}

impl Pace {
    /// Opens the job and times it.
    pub fn open(device: Option<&Device>) -> Result<Self> {
        let Some(device) = device else { return Self::of(None, 1) };
        let small = Self::of(Some(device), 2)?;
        // Four times the faces are sixteen times the pairs.
        if 16.0 * small.fastest <= LONG { Self::of(Some(device), 3) } else { Ok(small) }
    }

    /// The job over a ball of this detail.
    fn of(device: Option<&Device>, detail: u32) -> Result<Self> {
        let scene = Scene::load_with("sphere", &[format!("object.0.detail={detail}")])?;
        let solver = match brute(&Bench { scene: &scene, device }, Lighting::Moves, 0.0)? {
            Opened::Ready(solver) => Some(solver),
            Opened::NotOffered(_) => None,
        };
        let mut pace = Self { solver, fastest: f64::INFINITY };
        pace.seconds()?;
        Ok(pace)
    }

    /// Seconds that the job takes now, the minimum of two runs.
    pub fn seconds(&mut self) -> Result<f64> {
        let mut best = f64::INFINITY;
        if let Some(solver) = &mut self.solver {
            for _ in 0..2 {
                let start = Instant::now();
                solver.frame()?;
                best = best.min(start.elapsed().as_secs_f64());
            }
        }
        self.fastest = self.fastest.min(best);
        Ok(best)
    }

    /// This time as a multiple of the fastest so far; 1 without a job.
    pub fn share(&self, seconds: f64) -> f64 {
        if self.fastest.is_finite() { seconds / self.fastest } else { 1.0 }
    }
}
