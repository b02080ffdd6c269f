//! Whether the machine was busy with something else: a fixed small job, timed between points.
//!
//! A median is blind to what slows every frame of a point alike; a job that never changes sees it.

use std::time::Instant;

use super::method::brute;
use super::{Bench, Lighting, Opened, Solver};
use crate::error::Result;
use crate::gpu::Device;
use crate::scene::Scene;

/// Most that a larger job may take, seconds: it runs twice for each point.
const LONG: f64 = 0.1;

/// The job: brute force over a ball, on the device that is measured of 1,280 faces where that is short, else of 320; of
/// 80 on the CPU, whose reference is slow.
pub struct Pace {
    solver: Option<Box<dyn Solver>>,
    fastest: f64,
}

impl Pace {
    /// Opens the job.
    pub fn open(device: Option<&Device>) -> Result<Self> {
        let Some(device) = device else { return Self::of(None, 1) };
        let small = Self::of(Some(device), 2)?;
        // Four times the faces are sixteen times the pairs.
        if 16.0 * small.fastest <= LONG { Self::of(Some(device), 3) } else { Ok(small) }
    }

    /// The job over a ball of this detail.
    fn of(device: Option<&Device>, detail: u32) -> Result<Self> {
        let scene = Scene::load("sphere", &[format!("object.0.detail={detail}")])?;
        let solver = match brute(&Bench { scene: &scene, device }, Lighting::Moves, 0.0)? {
            Opened::Ready(solver) => Some(solver),
            Opened::NotOffered(_) => None,
        };
        let mut pace = Self { solver, fastest: f64::INFINITY };
        pace.seconds()?;
        Ok(pace)
    }

    /// Seconds that the job takes now, the better of two.
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

    /// So many seconds as a multiple of the fastest so far; 1 where there is no job.
    pub fn share(&self, seconds: f64) -> f64 {
        if self.fastest.is_finite() { seconds / self.fastest } else { 1.0 }
    }
}
