//! What a session reports to its callers about itself: the scene, the state, the plan, where it runs, and how often it
//! ran again.

use super::run::{Backend, Session};
use super::subdivide::Parts;
use crate::error::Result;
use crate::gpu::count::Tally;
use crate::gpu::{Device, KernelKey, Limits};
use crate::layout::BufferId;
use crate::pipeline::plan::Plan;
use crate::prepare::scene::Prepared;
use crate::prepare::units::Units;
use crate::scene::Scene;
use crate::state::State;

impl Session {
    /// The scene as it is rendered: after subdivision, with the latest lights, deformations and camera.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The state on the host. On a device its buffers are as of the last [`Session::fetch`].
    pub fn state(&self) -> &State {
        &self.prepared.state
    }

    /// How the state's numbers relate to the scene's.
    pub fn units(&self) -> &Units {
        &self.prepared.units
    }

    /// The prepared scene: the state, the trees, and which triangle of the state is which of a mesh.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// The stages that run, and those that do not with the reasons.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// How often a frame ran again because a list overflowed, since the session began.
    pub fn retries(&self) -> usize {
        self.retries
    }

    /// How often a frame ran again because the kept lists did not serve the contrast of its light, since the session
    /// began.
    pub fn relinks(&self) -> usize {
        self.relinks
    }

    /// What became of each object's triangles where `transport.subdivide` asks for subdivision; empty elsewhere.
    pub fn parts(&self) -> &[Parts] {
        &self.parts
    }

    /// The device that runs the stages; none where the CPU does.
    pub fn device(&self) -> Option<&Device> {
        match &self.backend {
            Backend::Gpu(gpu) => Some(gpu.device()),
            Backend::Cpu => None,
        }
    }

    /// The limits of that device.
    pub(crate) fn limits(&self) -> Option<&Limits> {
        self.device().map(Device::limits)
    }

    /// What each kernel has done since the last call, by the kernel's path. Empty on the CPU, and where kernels do not
    /// count.
    pub fn tallies(&self) -> Result<Vec<(String, Tally)>> {
        match &self.backend {
            Backend::Gpu(gpu) => gpu.kernels().tallies(),
            Backend::Cpu => Ok(Vec::new()),
        }
    }

    /// The pipelines that the device has built so far: kernel and specialization constants. Empty on the CPU.
    pub fn pipelines(&self) -> Vec<KernelKey> {
        match &self.backend {
            Backend::Gpu(gpu) => gpu.kernels().made(),
            Backend::Cpu => Vec::new(),
        }
    }

    /// The buffers that the device has allocated, with their bytes. Empty on the CPU.
    pub fn device_buffers(&self) -> Vec<(BufferId, u64)> {
        match &self.backend {
            Backend::Gpu(gpu) => gpu.buffers().collect(),
            Backend::Cpu => Vec::new(),
        }
    }
}
