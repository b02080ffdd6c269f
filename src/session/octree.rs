//! The irradiance octree as a transport: from the state's irradiance to its radiosity.
//!
//! It is not a stage: it runs on the host, whatever back end runs the stages.

use std::time::Instant;

use super::run::Session;
use crate::dipole::profile::Dipole;
use crate::error::{Input, Result};
use crate::gpu::Timing;
use crate::layout::BufferId;
use crate::pipeline::frame::before_host;
use crate::pipeline::plan::Change;
use crate::scene::{Distance, Transport};
use crate::state::{Object, State, Step};
use crate::transport::octree::{HOST, Octree, Sample};

/// The octree of a session, kept from frame to frame.
#[derive(Default)]
pub struct OctreeTransport {
    trees: Vec<Octree>,
    /// The centroids of each object's faces, internal length.
    centers: Vec<Vec<[f32; 3]>>,
    /// Solid angle above which a cell is opened, steradian.
    angle: f32,
}

impl OctreeTransport {
    /// The octree of these settings; an error if it cannot serve them.
    pub fn new(transport: &Transport) -> Result<Self> {
        if transport.distance != Distance::Radial {
            let fault = Input::new("the octree works with radial distances only").key("transport.distance");
            return Err(fault.found("table1").expected("radial, or another --transport than octree").into());
        }
        Ok(Self { angle: transport.octree_angle as f32, ..Self::default() })
    }

    /// Sums radiosity from the state's irradiance, both internal; rebuilds the trees if `light` has changed.
    pub fn run(&mut self, state: &mut State, light: bool) -> Timing {
        let start = Instant::now();
        if light {
            let samples = state.objects.iter().map(|object| samples(state, object));
            let (trees, centers) = samples.map(|all| (Octree::new(&all), places(&all))).unzip();
            (self.trees, self.centers) = (trees, centers);
        }
        let sources = state.objects.iter().zip(&state.data.object_params).zip(self.trees.iter().zip(&self.centers));
        for ((object, params), (tree, centers)) in sources.filter(|((object, _), _)| !object.opaque) {
            let dipoles = [0, 1, 2].map(|channel| Dipole::of(params, channel));
            let sums = tree.gather(&dipoles, self.angle, centers);
            state.data.radiosity[object.first.receivers..][..sums.len()].copy_from_slice(&sums);
        }
        Timing {
            name: HOST.name.into(),
            milliseconds: start.elapsed().as_secs_f64() * 1e3,
            start: f64::NAN,
            ..Timing::default()
        }
    }
}

impl Session {
    /// Runs these steps, with the octree between the stages before transport and those after it. The host uploads the
    /// octree's radiosity only if later stages read it.
    pub(super) fn run_octree(&mut self, steps: &[Step], change: Change) -> Result<Vec<Timing>> {
        let (before, after) = steps.split_at(before_host(steps));
        let mut times = self.run(before)?;
        if change.everything {
            self.fetch(&[BufferId::clusters])?;
        }
        let light = change.everything || change.light;
        if light {
            self.fetch(&[BufferId::irradiance])?;
        }
        if let Some(octree) = &mut self.octree {
            times.push(octree.run(&mut self.prepared.state, light));
        }
        if !after.is_empty() {
            self.send(&[BufferId::radiosity])?;
        }
        times.extend(self.run(after)?);
        Ok(times)
    }
}

/// Irradiance samples at the centroids of an object's faces; none for an opaque object.
fn samples(state: &State, object: &Object) -> Vec<Sample> {
    let (first, count, data) = (object.first, if object.opaque { 0 } else { object.count.faces }, &state.data);
    let sample = |face: usize| {
        let leaf = &data.clusters[first.nodes + data.leaves[face] as usize];
        Sample { position: leaf.center, area: leaf.area, irradiance: data.irradiance[face] }
    };
    (first.faces..first.faces + count).map(sample).collect()
}

fn places(samples: &[Sample]) -> Vec<[f32; 3]> {
    samples.iter().map(|sample| sample.position).collect()
}
