//! Read access to a session: scene, state, plan, device, and retry counts.

use std::time::Duration;

use super::run::Session;
use super::subdivide::Parts;
use crate::error::Result;
use crate::gpu::count::Tally;
use crate::gpu::{Device, KernelKey, Limits, Statistic};
use crate::layout::BufferId;
use crate::pipeline::plan::Plan;
use crate::prepare::scene::Prepared;
use crate::prepare::units::Units;
use crate::scene::Scene;
use crate::state::{DeviceState, State};

impl Session {
    /// The scene as it is rendered: after subdivision, with the latest lights, deformations and camera.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The state on the host. On a device its buffers are as of the last [`Session::fetch`].
    pub fn state(&self) -> &State {
        &self.prepared.state
    }

    /// Conversion between the state's units and the scene's.
    pub fn units(&self) -> &Units {
        &self.prepared.units
    }

    /// The prepared scene: the state, the trees, and the mesh triangle of each triangle of the state.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// The stages that run, and the others with the reasons.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// How often a frame was repeated because a list overflowed, since the session began.
    pub fn retries(&self) -> usize {
        self.retries
    }

    /// How often a frame was repeated because the kept lists did not suit the irradiance ratio of its light, since
    /// the session began.
    pub fn relinks(&self) -> usize {
        self.relinks
    }

    /// How each object's triangles were subdivided, because they were long or `transport.subdivide` asks for it; empty
    /// if no object's were.
    pub fn parts(&self) -> &[Parts] {
        &self.parts
    }

    /// The device that runs the stages; none on the CPU.
    pub fn device(&self) -> Option<&Device> {
        self.gpu.as_ref().map(DeviceState::device)
    }

    /// The limits of that device.
    pub(crate) fn limits(&self) -> Option<&Limits> {
        self.device().map(Device::limits)
    }

    /// Each dispatch's counts since the last call, in their order, after the kernel's path. Empty on the CPU, and for
    /// kernels without counters.
    pub fn tallies(&self) -> Result<Vec<([String; 2], Tally)>> {
        self.gpu.as_ref().map_or(Ok(Vec::new()), |gpu| gpu.kernels().tallies())
    }

    /// The pipelines built on the device so far: kernel and specialization constants. Empty on the CPU.
    pub fn pipelines(&self) -> Vec<KernelKey> {
        self.gpu.as_ref().map_or(Vec::new(), |gpu| gpu.kernels().made())
    }

    /// The same with the time in which the driver created each pipeline, and what its compiler says of it.
    pub fn pipeline_facts(&self) -> Result<Vec<(KernelKey, Duration, Vec<Statistic>)>> {
        self.gpu.as_ref().map_or(Ok(Vec::new()), |gpu| gpu.kernels().facts())
    }

    /// The buffers that the device has allocated, with their bytes. Empty on the CPU.
    pub fn device_buffers(&self) -> Vec<(BufferId, u64)> {
        self.gpu.iter().flat_map(DeviceState::buffers).collect()
    }
}
