//! Choices that Vulkan leaves to a program: how kernels are made, bound, ordered and submitted, and the axes along
//! which they can be varied. Everything runs with the default ones, but for what [`AXES`] lists.

use std::collections::BTreeMap;

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

/// A choice between several ways: the type, the field of [`Choices`], the name and what is chosen, and each way, the
/// default first.
macro_rules! choice {
    (
        $kind:ident, $field:ident, $name:literal, $about:literal:
        $first:ident = $first_name:literal $first_about:literal,
        $($way:ident = $way_name:literal $way_about:literal,)*
    ) => {
        #[doc = $about]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
        pub enum $kind {
            #[doc = $first_about]
            #[default]
            $first,
            $(#[doc = $way_about] $way,)*
        }

        impl $kind {
            const AXIS: Axis = Axis {
                name: $name,
                about: $about,
                values: &[
                    Value { name: $first_name, about: $first_about, set: |choices| choices.$field = Self::$first },
                    $(Value { name: $way_name, about: $way_about, set: |choices| choices.$field = Self::$way },)*
                ],
            };
        }
    };
}

/// How the API is used. No choice changes what is computed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choices {
    /// Invocations of a group by stage, where kernels leave that open; of all others under the empty name.
    pub groups: BTreeMap<String, u32>,
    /// The subgroup size that pipelines require; what the driver likes where there is none.
    pub subgroup: Option<u32>,
    /// Whether kernels do without shuffles.
    pub no_shuffles: bool,
    /// Invocations that share a block or a sample, where kernels have them; if not 1, some share rays, near triangles
    /// and climbs too. By the device's kind where there is none.
    pub lanes: Option<u32>,
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
    /// What of a frame has times of its own.
    pub timed: Timed,
}

/// What of a frame has times of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timed {
    /// Each step of a stage.
    #[default]
    Steps,
    /// Each dispatch, by its kernel's name.
    Kernels,
    /// Each dispatch, by its kernel's name and its number among that kernel's dispatches in the submission.
    Dispatches,
}

choice!(
    Descriptors, descriptors, "descriptors", "how buffers are bound":
    Shared = "shared" "a set for each kernel and ranges",
    Dispatch = "dispatch" "a new set for each dispatch",
    Frame = "frame" "one layout with all bindings, as few sets as can be",
    Push = "push" "no sets (VK_KHR_push_descriptor)",
);

choice!(
    Constants, constants, "constants", "where kernels find what changes from dispatch to dispatch":
    Push = "push" "push constants",
    Uniform = "uniform" "a uniform buffer at dynamic offsets",
    Specialization = "specialization" "a pipeline for each value",
);

choice!(
    Submissions, submissions, "submissions", "how a frame is submitted":
    Reused = "reused" "as few submissions as can be, recorded once for frames that are alike",
    Frame = "frame" "as few submissions as can be, recorded anew",
    Step = "step" "recorded anew, one submission a step",
    Secondary = "secondary" "a secondary command buffer a step",
);

choice!(
    Barriers, barriers, "barriers", "how dispatches that depend on each other are ordered":
    Elided = "elided" "a global barrier where one is needed",
    Every = "every" "a global barrier before each dispatch",
    Buffer = "buffer" "where needed, for these buffers only",
    Events = "events" "events, set as early as can be",
    Synchronization2 = "sync2" "as elided (VK_KHR_synchronization2)",
);

choice!(
    MemoryKind, memory, "memory", "the memory of buffers":
    Local = "local" "the device's own, parts of large allocations",
    Visible = "visible" "visible to the host, written through",
    Cached = "cached" "visible to the host, cached",
    Dedicated = "dedicated" "the device's own, an allocation a buffer",
);

choice!(
    Queues, queues, "queues", "queues that the steps of a frame are submitted to":
    One = "one" "one, in the order of the frame",
    Apart = "apart" "one, a submission a step, ordered by timeline semaphores",
    Two = "two" "two of a family, for steps that do not depend on each other",
);

choice!(
    Waiting, waiting, "waiting", "how the host waits for a submission":
    Block = "block" "asleep, until the driver wakes it (vkWaitForFences)",
    Poll = "poll" "awake, asking again and again (vkGetFenceStatus)",
);

choice!(
    Cache, cache, "cache", "the pipeline cache; timed are the making of all pipelines, and a first and a second frame":
    Cold = "cold" "a new, empty cache",
    Without = "none" "no cache",
    Warm = "warm" "the cache that has them",
    Disk = "disk" "a new cache, made from the data of one that has them",
);

choice!(
    Optimization, optimization, "spirv", "what the compiler of GLSL optimises for":
    Performance = "performance" "speed",
    Size = "size" "size",
    Without = "none" "nothing",
);

/// A value that sets a field.
macro_rules! value {
    ($name:literal, $about:literal, $($field:ident).+ = $value:expr) => {
        Value { name: $name, about: $about, set: |choices| choices.$($field).+ = $value }
    };
}

/// Sets the number of invocations of all kernels that leave it open.
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
        name: "lanes",
        about: "invocations that share a block, a sample, its receivers or a ray",
        values: &[
            value!("any", "1 on a processor, else up to 128", lanes = None),
            value!("1", "each walks alone", lanes = Some(1)),
            value!("32", "32 invocations, a group of their own", lanes = Some(32)),
            value!("64", "64 invocations", lanes = Some(64)),
            value!("128", "128 invocations", lanes = Some(128)),
        ],
    },
    Descriptors::AXIS,
    Constants::AXIS,
    Submissions::AXIS,
    Barriers::AXIS,
    MemoryKind::AXIS,
    Queues::AXIS,
    Waiting::AXIS,
    Cache::AXIS,
    Optimization::AXIS,
];

impl Axis {
    /// The value of this name.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<&'static Value> {
        self.values.iter().find(|value| value.name == name)
    }
}

impl Choices {
    /// Invocations of a group of this kernel, if they are chosen.
    pub(super) fn group(&self, kernel: &str) -> Option<u32> {
        let chosen = self.groups.iter().find(|(stage, _)| kernel.split('/').any(|part| part == stage.as_str()));
        chosen.map(|(_, size)| *size).or_else(|| self.groups.get("").copied())
    }
}
