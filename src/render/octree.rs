//! The irradiance octree as a transport: what a frame needs of it, from the state's irradiance to its radiosity.
//!
//! It is no stage: it runs on the host in native code, wherever the stages run.

use std::time::Instant;

use crate::baseline::octree::{Octree, Sample};
use crate::dipole::profile::Dipole;
use crate::error::{Input, Result};
use crate::gpu::Timing;
use crate::scene::{Distance, Transport};
use crate::state::State;

/// Its name among the times of a frame.
pub const NAME: &str = "octree";
/// What it does, in words.
pub const ABOUT: &str = "irradiance octree over the faces' centroids, in native code on the host";
/// Where it is from.
pub const EQUATION: &str = "Jensen and Buhler 2002";

/// The octree of a session, kept from frame to frame.
#[derive(Default)]
pub struct OctreeTransport {
    tree: Octree,
    /// The faces' centroids, internal length.
    centers: Vec<[f32; 3]>,
    /// Solid angle from which on a cell is opened, steradian.
    angle: f32,
}

impl OctreeTransport {
    /// For these settings, or the fault in them.
    pub fn new(transport: &Transport) -> Result<Self> {
        if transport.distance != Distance::Radial {
            let fault = Input::new("the octree serves radial distances only").key("transport.distance");
            return Err(fault.found("table1").expected("radial, or another --transport than octree").into());
        }
        Ok(Self { angle: transport.octree_angle as f32, ..Self::default() })
    }

    /// Sums radiosity from the state's irradiance, both internal; builds the tree anew if `light` has changed.
    pub fn run(&mut self, state: &mut State, light: bool) -> Timing {
        let start = Instant::now();
        let data = &mut state.data;
        if light {
            let leaves = data.leaves.iter().map(|&leaf| &data.clusters[leaf as usize]);
            let sample = |(leaf, &irradiance): (&crate::layout::Cluster, &[f32; 3])| Sample {
                position: leaf.center,
                area: leaf.area,
                irradiance,
            };
            let samples: Vec<Sample> = leaves.zip(&data.irradiance).map(sample).collect();
            self.centers = samples.iter().map(|sample| sample.position).collect();
            self.tree = Octree::new(&samples);
        }
        let dipoles = [0, 1, 2].map(|channel| Dipole::of(&data.frame[0], channel));
        data.radiosity = self.tree.gather(&dipoles, self.angle, &self.centers);
        Timing { name: NAME.into(), milliseconds: start.elapsed().as_secs_f64() * 1e3 }
    }
}
