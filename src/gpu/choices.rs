//! Choices that Vulkan leaves to a program: how kernels are made, bound, ordered and submitted. Everything runs with
//! the default ones, but for what [`super::AXES`] lists.

use std::collections::BTreeMap;

/// How the API is used. No choice changes what is computed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choices {
    /// Invocations of a group by stage, where kernels leave that open; of all others under the empty name.
    pub groups: BTreeMap<String, u32>,
    /// The subgroup size that pipelines require; what the driver likes where there is none.
    pub subgroup: Option<u32>,
    /// Whether kernels do without shuffles.
    pub no_shuffles: bool,
    /// How buffers are bound.
    pub descriptors: Descriptors,
    /// Where kernels find what changes from dispatch to dispatch.
    pub constants: Constants,
    /// How a frame is submitted.
    pub submissions: Submissions,
    /// How dispatches that depend on each other are kept in order.
    pub barriers: Barriers,
    /// The memory of buffers.
    pub memory: MemoryKind,
    /// The queues of a frame.
    pub queues: Queues,
    /// How the host waits for a submission.
    pub waiting: Waiting,
    /// What pipelines are made from, where a device has made them before.
    pub cache: Cache,
    /// What the compiler of GLSL optimises for.
    pub optimization: Optimization,
    /// The byte that fills the buffers of a scene at first: 0, so that what no kernel writes can be compared; 0xff, so
    /// that whatever reads it fails. Without one they hold what the driver left there.
    pub fill: Option<u8>,
}

/// How buffers are bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Descriptors {
    /// A set for each kernel and each choice of ranges, which dispatches share.
    #[default]
    Shared,
    /// A new set for each dispatch.
    Dispatch,
    /// One set layout with every binding for all kernels, and a set for all dispatches that agree on the ranges.
    Frame,
    /// No sets: `VK_KHR_push_descriptor`.
    Push,
}

/// Where kernels find what changes from dispatch to dispatch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Constants {
    /// Push constants.
    #[default]
    Push,
    /// A uniform buffer, at dynamic offsets.
    Uniform,
    /// Specialization constants: a pipeline for each value.
    Specialization,
}

/// How a frame is submitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Submissions {
    /// Recorded anew, submitted once.
    #[default]
    Frame,
    /// Recorded anew, one submission a step; only the last is waited for.
    Step,
    /// Recorded once, and submitted again as long as the dispatches stay the same.
    Reused,
    /// Each step in a secondary command buffer.
    Secondary,
}

/// How dispatches that depend on each other are kept in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Barriers {
    /// A barrier for all memory before a dispatch that depends on one since the last barrier.
    #[default]
    Elided,
    /// A barrier for all memory before each dispatch.
    Every,
    /// A barrier for the buffers in question only.
    Buffer,
    /// An event, set after the last dispatch that another one depends on.
    Events,
    /// As `Elided`, by `VK_KHR_synchronization2`.
    Synchronization2,
}

/// The memory of buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MemoryKind {
    /// The device's own, parts of large allocations.
    #[default]
    Local,
    /// Visible to the host, written through.
    Visible,
    /// Visible to the host, cached.
    Cached,
    /// The device's own, an allocation a buffer.
    Dedicated,
}

/// The queues of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Queues {
    /// One.
    #[default]
    One,
    /// One, to which each step is submitted apart as if there were two, in an order that semaphores keep.
    Apart,
    /// Two of one family: steps that do not depend on each other may run at the same time.
    Two,
}

/// How the host waits for a submission.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Waiting {
    /// Asleep, until the driver wakes it.
    #[default]
    Block,
    /// Awake for some milliseconds, asking again and again.
    Poll,
}

/// What pipelines are made from, where a device has made them before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cache {
    /// A pipeline cache that was empty at first.
    #[default]
    Cold,
    /// No pipeline cache.
    Without,
    /// The pipeline cache that they were put into.
    Warm,
    /// A pipeline cache that is read from a file.
    Disk,
}

/// What the compiler of GLSL optimises for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Optimization {
    /// Speed.
    #[default]
    Performance,
    /// Size.
    Size,
    /// Nothing.
    Without,
}

impl Choices {
    /// Invocations of a group of this kernel, if they are chosen.
    pub(super) fn group(&self, kernel: &str) -> Option<u32> {
        let own = self.groups.iter().find(|(stage, _)| kernel.split('/').any(|part| part == stage.as_str()));
        own.map(|(_, size)| *size).or_else(|| self.groups.get("").copied())
    }
}
