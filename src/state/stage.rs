//! [`Stage`]: the declaration of one step of the frame, with all that the frame, the plan, conformance and the
//! profile need to know of it.

use std::collections::BTreeSet;

use crate::error::Result;
use crate::gpu::{Place, accesses, kernel_names};
use crate::layout::{BUFFER_IDS, BufferId};

use super::{Carrier, Granularity, Method, Object, Pass, Scope, State, Tolerance, Update};

/// One run of a stage.
#[derive(Clone, Copy)]
pub struct Step {
    /// The stage.
    pub stage: &'static Stage,
    /// The part of the work that it does.
    pub at: Scope,
}

impl Step {
    /// Runs the CPU reference. References handle one object only: of several, this one is extracted as a state of its
    /// own.
    pub fn reference(&self, state: &mut State) {
        let (stage, at) = (self.stage, self.at);
        if at == Scope::SCENE || state.objects.len() < 2 {
            return (stage.cpu)(state, at);
        }
        let mut alone = state.alone(at.object);
        (stage.cpu)(&mut alone, Scope { object: 0, ..at });
        state.take(at.object, &alone, stage.writes.iter().map(|(id, _, _)| *id));
    }

    /// Which part of the work it does.
    #[must_use]
    pub fn place(&self) -> Place {
        let Scope { object, chunk, group } = self.at;
        let [object, group] = [("object", object), ("channel group", group)].map(Some);
        let chunk = |word| Some((word, chunk));
        Place(match self.stage.granularity {
            _ if self.at == Scope::SCENE => [None; 3],
            Granularity::Scene => [None; 3],
            Granularity::Object => [object, None, None],
            Granularity::Chunk => [object, chunk("chunk"), None],
            Granularity::Group => [object, group, None],
            Granularity::Batch => [object, group, chunk("batch")],
            Granularity::Iteration => [object, chunk("iteration"), None],
        })
    }
}

/// In words, with the scope's numbers from 0 on: `link of object 0, channel group 1, batch 2`.
impl std::fmt::Display for Step {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.stage.name, self.place()) {
            (name, place) if place == Place::default() => write!(out, "{name} of the whole scene"),
            (name, place) => write!(out, "{name} of {place}"),
        }
    }
}

/// In short: `link[0.1.2]` of object, group and chunk.
impl std::fmt::Debug for Step {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.at {
            Scope::SCENE => out.write_str(self.stage.name),
            Scope { object, chunk, group } => write!(out, "{}[{object}.{group}.{chunk}]", self.stage.name),
        }
    }
}

/// How a stage treats the old contents of a buffer that it writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It ignores them: conformance fills the buffer with poison first.
    Output,
    /// It reads some of them, or some must survive.
    Update,
    /// It ignores them, and what it leaves depends on which invocation comes first: its kernels hand that on among
    /// themselves, and nothing else reads it. Not compared.
    Scratch,
}

/// One step of the frame, on the CPU and on the GPU.
pub struct Stage {
    /// Its name, the same in Rust, in GLSL, in the profile, in the conformance table and in the guide.
    pub name: &'static str,
    /// The module it lives in; its shaders are `glsl/MODULE/NAME.comp` or `glsl/MODULE/NAME/*.comp`.
    pub module: &'static str,
    /// What it does, in one sentence.
    pub about: &'static str,
    /// The equation or section it comes from.
    pub equation: &'static str,
    /// The buffers it writes, how it treats their old contents, and the tolerance of the new ones.
    pub writes: &'static [(BufferId, Role, Tolerance)],
    /// Why the tolerances are what they are.
    pub reason: &'static str,
    /// Sizes of the buffers that it writes, where the partition does not imply them; only one stage may declare each.
    pub sizes: &'static [(BufferId, Size)],
    /// How often it runs.
    pub granularity: Granularity,
    /// The carriers of light in whose frames it has a place.
    pub carriers: &'static [Carrier],
    /// What else a frame must have.
    pub needs: &'static [Need],
    /// The objects that it processes.
    pub serves: Serves,
    /// Why a frame of this state does without it, if it does.
    pub skip: fn(&State) -> Option<&'static str>,
    /// Whether it runs in a frame after this update.
    pub runs: fn(&Update) -> bool,
    /// The CPU reference.
    pub cpu: Cpu,
    /// Records its dispatches.
    pub gpu: Gpu,
}

/// The CPU reference of a stage.
pub type Cpu = fn(&mut State, Scope);
/// The function that records the dispatches of a stage.
pub type Gpu = fn(&mut Pass<'_>) -> Result<()>;

impl Stage {
    /// A stage that has no place in any frame, and no name. Each module declares from this one what its stages have in
    /// common, and each stage declares the rest.
    #[must_use]
    pub const fn new(cpu: Cpu, gpu: Gpu) -> Self {
        Self {
            name: "",
            module: "",
            about: "",
            equation: "",
            writes: &[],
            reason: "",
            sizes: &[],
            granularity: Granularity::Scene,
            carriers: &[],
            needs: &[],
            serves: Serves::ALL,
            skip: |_| None,
            runs: |_| false,
            cpu,
            gpu,
        }
    }

    /// Whether it declares all that no default can: its names, what it computes by which equation, what it writes, and
    /// why the tolerances are what they are.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        let named = !self.name.is_empty() && !self.module.is_empty();
        let explained = !self.about.is_empty() && !self.equation.is_empty() && !self.reason.is_empty();
        named && explained && !self.writes.is_empty()
    }

    /// Whether it writes a buffer.
    #[must_use]
    pub const fn writes(&self, id: BufferId) -> bool {
        let mut k = 0;
        while k < self.writes.len() {
            if self.writes[k].0 as usize == id as usize {
                return true;
            }
            k += 1;
        }
        false
    }

    /// The buffers that it writes and others may read.
    pub fn results(&self) -> impl Iterator<Item = BufferId> {
        self.writes.iter().filter(|(_, role, _)| *role != Role::Scratch).map(|(id, ..)| *id)
    }

    /// Whether a buffer is for its own kernels alone.
    #[must_use]
    pub fn is_scratch(&self, id: BufferId) -> bool {
        self.writes(id) && !self.results().any(|known| known == id)
    }

    /// The buffers that its kernels read, except those that it writes, too: as their SPIR-V declares them.
    pub fn reads(&self) -> Result<BTreeSet<BufferId>> {
        let mut reads = BTreeSet::new();
        for kernel in kernel_names().filter(|kernel| self.owns(kernel)) {
            let read = accesses(kernel)?.into_iter().filter(|access| access.reads);
            reads.extend(read.map(|access| BUFFER_IDS[access.binding as usize]));
        }
        reads.retain(|&buffer| !self.writes(buffer));
        Ok(reads)
    }

    /// Whether this kernel is one of its own: `MODULE/STAGE` or `MODULE/STAGE/PART`.
    #[must_use]
    pub fn owns(&self, kernel: &str) -> bool {
        let inner = |whole: &'_ str, folder: &str| whole.strip_prefix(folder)?.strip_prefix('/').map(String::from);
        inner(kernel, self.module).is_some_and(|rest| rest == self.name || inner(&rest, self.name).is_some())
    }

    /// Whether this is that stage.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        self.name == other.name
    }

    /// Whether it fills lists that may overflow.
    #[must_use]
    pub fn fills_lists(&self) -> bool {
        self.writes(BufferId::counters) && self.sizes.iter().any(|(_, size)| matches!(size, Size::Grows(_)))
    }
}

/// A step of the frame that always runs on the host, whether stages run on the CPU or on a device.
pub struct Host {
    /// Its name.
    pub name: &'static str,
    /// What it does, in one sentence.
    pub about: &'static str,
    /// The paper it comes from.
    pub equation: &'static str,
    /// The buffer that it reads.
    pub reads: BufferId,
    /// The buffer that it writes.
    pub writes: BufferId,
    /// The carrier of light in whose frames it has a place.
    pub carrier: Carrier,
}

/// What a frame must have for a stage to have a place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A light that shines.
    Light,
    /// A picture to be made.
    Picture,
    /// A picture to be made, or a light that casts shadows.
    Rays,
}

/// The objects that a stage processes.
#[derive(Clone, Copy)]
pub struct Serves {
    /// Whether it processes this one.
    pub object: fn(&Object, &Method) -> bool,
    /// What a plan says where it processes none.
    pub none: &'static str,
}

impl Serves {
    /// Every object.
    pub const ALL: Self = Self { object: |_, _| true, none: "there is no object" };
    /// Objects that light enters.
    pub const TRANSLUCENT: Self = Self { object: |object, _| !object.opaque, none: "every object is opaque" };
    /// Objects whose light is needed per triangle.
    pub const LIT_BY_FACE: Self = Self {
        object: |object, method| object.lit_by_face() && (object.opaque || method.local.is_none()),
        none: "light is evaluated where the pixels are",
    };
}

/// How many elements a buffer has.
#[derive(Clone, Copy)]
pub enum Size {
    /// This many.
    Elements(fn(&State) -> usize),
    /// At first this many: a guess that grows where a frame turns out to need more.
    Grows(fn(&State) -> usize),
}
