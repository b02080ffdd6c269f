//! The axes along which the use of the API can be varied: each lists what one choice could be.

use super::choices::{
    Barriers, Cache, Choices, Constants, Descriptors, MemoryKind, Optimization, Queues, Submissions, Waiting,
};
use crate::layout::GROUP_SIZE;

/// One choice, and what it could be.
pub struct Axis {
    /// Its name, `descriptors`.
    pub name: &'static str,
    /// What is chosen.
    pub about: &'static str,
    /// The default first.
    pub values: &'static [Value],
}

/// What one choice could be.
pub struct Value {
    /// Its name, `push`.
    pub name: &'static str,
    /// What it means.
    pub about: &'static str,
    /// Makes this choice.
    pub set: fn(&mut Choices),
}

/// A value that is that of a field.
macro_rules! value {
    ($name:literal, $about:literal, $($field:ident).+ = $value:expr) => {
        Value { name: $name, about: $about, set: |choices| choices.$($field).+ = $value }
    };
}

/// A number of invocations for all kernels that leave it open.
fn grouped(choices: &mut Choices, size: u32) {
    choices.groups.insert(String::new(), size);
}

/// Every choice.
pub static AXES: &[Axis] = &[
    Axis {
        name: "group",
        about: "invocations of a work group, where a kernel leaves that open; group.STAGE for one stage",
        values: &[
            Value { name: "64", about: "what kernels are written for", set: |c| grouped(c, GROUP_SIZE) },
            Value { name: "8", about: "few walks that wait for each other", set: |c| grouped(c, 8) },
            Value { name: "16", about: "a quarter of it", set: |c| grouped(c, 16) },
            Value { name: "32", about: "half of it", set: |c| grouped(c, 32) },
            Value { name: "128", about: "twice as many", set: |c| grouped(c, 128) },
            Value { name: "256", about: "four times as many", set: |c| grouped(c, 256) },
        ],
    },
    Axis {
        name: "subgroup",
        about: "subgroup size that pipelines require (VK_EXT_subgroup_size_control)",
        values: &[
            value!("any", "what the driver chooses", subgroup = None),
            value!("4", "4 invocations", subgroup = Some(4)),
            value!("8", "8 invocations", subgroup = Some(8)),
            value!("16", "16 invocations", subgroup = Some(16)),
            value!("32", "32 invocations", subgroup = Some(32)),
            value!("64", "64 invocations", subgroup = Some(64)),
        ],
    },
    Axis {
        name: "shuffles",
        about: "loads shared in a subgroup",
        values: &[
            value!("on", "by subgroupShuffle", no_shuffles = false),
            value!("off", "each invocation loads for itself", no_shuffles = true),
        ],
    },
    Axis {
        name: "descriptors",
        about: "how buffers are bound",
        values: &[
            value!("shared", "a set for each kernel and ranges", descriptors = Descriptors::Shared),
            value!("dispatch", "a new set for each dispatch", descriptors = Descriptors::Dispatch),
            value!("frame", "one layout with all bindings, as few sets as can be", descriptors = Descriptors::Frame),
            value!("push", "no sets (VK_KHR_push_descriptor)", descriptors = Descriptors::Push),
        ],
    },
    Axis {
        name: "constants",
        about: "where kernels find what changes from dispatch to dispatch",
        values: &[
            value!("push", "push constants", constants = Constants::Push),
            value!("uniform", "a uniform buffer at dynamic offsets", constants = Constants::Uniform),
            value!("specialization", "a pipeline for each value", constants = Constants::Specialization),
        ],
    },
    Axis {
        name: "submissions",
        about: "how a frame is submitted",
        values: &[
            value!("frame", "recorded anew, one submission", submissions = Submissions::Frame),
            value!("step", "recorded anew, one submission a step", submissions = Submissions::Step),
            value!("reused", "recorded once, submitted again", submissions = Submissions::Reused),
            value!("secondary", "a secondary command buffer a step", submissions = Submissions::Secondary),
        ],
    },
    Axis {
        name: "barriers",
        about: "how dispatches that depend on each other are ordered",
        values: &[
            value!("elided", "a global barrier where one is needed", barriers = Barriers::Elided),
            value!("every", "a global barrier before each dispatch", barriers = Barriers::Every),
            value!("buffer", "where needed, for these buffers only", barriers = Barriers::Buffer),
            value!("events", "events, set as early as can be", barriers = Barriers::Events),
            value!("sync2", "as elided (VK_KHR_synchronization2)", barriers = Barriers::Synchronization2),
        ],
    },
    Axis {
        name: "memory",
        about: "the memory of buffers",
        values: &[
            value!("local", "the device's own, parts of large allocations", memory = MemoryKind::Local),
            value!("visible", "visible to the host, written through", memory = MemoryKind::Visible),
            value!("cached", "visible to the host, cached", memory = MemoryKind::Cached),
            value!("dedicated", "the device's own, an allocation a buffer", memory = MemoryKind::Dedicated),
        ],
    },
    Axis {
        name: "queues",
        about: "queues that the steps of a frame are submitted to",
        values: &[
            value!("one", "one, in the order of the frame", queues = Queues::One),
            value!("apart", "one, a submission a step, ordered by timeline semaphores", queues = Queues::Apart),
            value!("two", "two of a family, for steps that do not depend on each other", queues = Queues::Two),
        ],
    },
    Axis {
        name: "waiting",
        about: "how the host waits for a submission",
        values: &[
            value!("block", "asleep, until the driver wakes it (vkWaitForFences)", waiting = Waiting::Block),
            value!("poll", "awake, asking again and again (vkGetFenceStatus)", waiting = Waiting::Poll),
        ],
    },
    Axis {
        name: "cache",
        about: "the pipeline cache; timed are the making of all pipelines, and a first and a second frame",
        values: &[
            value!("cold", "a new, empty cache", cache = Cache::Cold),
            value!("none", "no cache", cache = Cache::Without),
            value!("warm", "the cache that has them", cache = Cache::Warm),
            value!("disk", "a new cache, made from the data of one that has them", cache = Cache::Disk),
        ],
    },
    Axis {
        name: "spirv",
        about: "what the compiler of GLSL optimises for",
        values: &[
            value!("performance", "speed", optimization = Optimization::Performance),
            value!("size", "size", optimization = Optimization::Size),
            value!("none", "nothing", optimization = Optimization::Without),
        ],
    },
];

impl Axis {
    /// The value of this name.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<&'static Value> {
        self.values.iter().find(|value| value.name == name)
    }
}
