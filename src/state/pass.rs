//! What a stage records its dispatches with: a [`Pass`] sends them to a device or lists them.

use super::device::{Call, DeviceState, Groups};
use super::trace::{Trace, Traced, Way};
use super::{Object, Scope, State, Step};
use crate::error::Result;
use crate::gpu::{Access, Device, Recorder, Timed, Timing, accesses};
use crate::layout::{BUFFER_IDS, BufferId, GROUP_SIZE, Range};

/// What a stage records its dispatches with.
pub struct Pass<'a> {
    /// The host's state: sizes, schedule and settings only; its contents may be older than the device's.
    pub state: &'a State,
    /// The part of the work at hand.
    pub at: Scope,
    step: Step,
    sink: Sink<'a>,
}

/// Where dispatches go.
enum Sink<'a> {
    Device(&'a DeviceState, &'a mut Recorder),
    Part(&'a DeviceState, &'a mut Recorder, OneOf<'a>),
    Ask(Width, &'a mut dyn FnMut(&Call<'_>) -> Result<()>),
    Trace(&'a DeviceState, &'a mut Trace, Way<'a>),
}

/// The dispatch of a step that is recorded, and how many the step has requested so far.
struct OneOf<'a> {
    index: usize,
    seen: &'a mut usize,
}

/// A dispatch that a step requests.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispatch {
    /// The stage.
    pub stage: &'static str,
    /// The kernel, `transport/blocks/gather/direct`.
    pub kernel: String,
    /// Its specialization constants 0, 1, ...
    pub constants: Vec<u32>,
    /// The scope.
    pub at: Scope,
    /// Invocations; none where the device determines the number itself.
    pub invocations: Option<usize>,
    /// The buffer that counts its groups where the device does.
    pub counted: Option<BufferId>,
}

/// A part of a buffer that a dispatch binds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The buffer.
    pub slot: BufferId,
    /// Its bytes, begin and end.
    pub range: [u64; 2],
    /// Whether it is read.
    pub reads: bool,
    /// Whether it is written.
    pub writes: bool,
}

impl Dispatch {
    /// The part of each buffer that it binds.
    pub fn bound(&self, state: &State) -> Result<Vec<Bound>> {
        let range = |slot: BufferId| {
            let (first, count) = state.part(slot, self.at);
            [first, first + count].map(|element| (element * slot.spec().stride) as u64)
        };
        let accesses = accesses(&self.kernel)?;
        let known = accesses
            .iter()
            .filter_map(|access| Some((state.data.bound(*BUFFER_IDS.get(access.binding as usize)?), access)));
        let bound = |(slot, access): (BufferId, &Access)| Bound {
            slot,
            range: range(slot),
            reads: access.reads,
            writes: access.writes,
        };
        Ok(known.map(bound).collect())
    }

    /// The buffers of any bytes that it binds or that count its groups, and whether it reads and writes them.
    #[cfg(feature = "measure")]
    pub(crate) fn uses(&self, state: &State) -> Result<Vec<(BufferId, bool, bool)>> {
        let bound = self.bound(state)?.into_iter().filter(|bound| bound.range[0] < bound.range[1]);
        let bound = bound.map(|bound| (bound.slot, bound.reads, bound.writes));
        Ok(bound.chain(self.counted.map(|slot| (slot, true, false))).collect())
    }
}

/// A level's part of the state's `order`.
fn in_order(level: std::ops::Range<u32>) -> Range {
    Range { first: level.start, count: level.end - level.start }
}

/// What a device runs at once, as far as dispatches depend on it.
#[derive(Clone, Copy, Debug)]
pub struct Width {
    /// Invocations of a subgroup in which kernels may shuffle; 1 where they may not.
    pub subgroup: usize,
    /// Whether invocations share items: not on a processor, of which an invocation is a lane of a vector.
    pub shares: bool,
}

impl Width {
    /// The width of a GPU, where there is no device to ask.
    pub const GPU: Self = Self { subgroup: 32, shares: true };

    /// The width of this device.
    pub fn of(device: &Device) -> Self {
        Self { subgroup: device.subgroup_that_shuffles(GROUP_SIZE) as usize, shares: device.lanes() > 1 }
    }
}

/// Tells each dispatch that a step requests on a device of this width; needs no device.
pub fn requested(state: &State, step: Step, width: Width, told: &mut dyn FnMut(&Call<'_>) -> Result<()>) -> Result<()> {
    (step.stage.gpu)(&mut Pass { state, at: step.at, step, sink: Sink::Ask(width, told) })
}

/// Lists what these steps dispatch on a device of this width; needs no device.
pub fn dispatches(state: &State, steps: &[Step], width: Width) -> Result<Vec<Dispatch>> {
    let mut found = Vec::new();
    for step in steps {
        requested(state, *step, width, &mut |call| {
            let (invocations, counted) = match call.groups {
                Groups::Invocations(0) | Groups::Whole(0) => return Ok(()),
                Groups::Invocations(count) => (Some(count), None),
                Groups::Whole(count) => (Some(count * GROUP_SIZE as usize), None),
                Groups::Counted { slot, .. } => (None, Some(slot)),
            };
            let (stage, kernel, constants) = (step.stage.name, call.kernel.to_string(), call.constants.to_vec());
            found.push(Dispatch { stage, kernel, constants, at: call.at, invocations, counted });
            Ok(())
        })?;
    }
    Ok(found)
}

impl DeviceState {
    /// Runs a step's dispatches one at a time, and notes what each was given and what it left. Before each runs,
    /// `told` gets the trace of those that have run, and the one that is next.
    pub fn trace(
        &self,
        state: &State,
        step: Step,
        told: &mut dyn FnMut(&Trace, &Traced) -> Result<()>,
    ) -> Result<Trace> {
        let mut trace = Trace::default();
        let mut told = |done: &Trace, next: &Traced| told(done, next);
        let sink = Sink::Trace(self, &mut trace, Way::Run(&mut told));
        (step.stage.gpu)(&mut Pass { state, at: step.at, step, sink })?;
        Ok(trace)
    }

    /// Notes a step's dispatches, and runs none of them; `after` is the reference's state after the step.
    pub fn list(&self, state: &State, step: Step, after: &State) -> Result<Trace> {
        let mut trace = Trace::default();
        let sink = Sink::Trace(self, &mut trace, Way::List(after));
        (step.stage.gpu)(&mut Pass { state, at: step.at, step, sink })?;
        Ok(trace)
    }

    /// Records and submits these steps as one frame; returns the time of each.
    pub fn run(&self, state: &State, steps: &[Step]) -> Result<Vec<Timing>> {
        let apart = self.device().choices().timed != Timed::Steps;
        let parts = if apart { self.count(state, steps)? } else { steps.len() };
        let mut recorder = Recorder::new(self.device(), parts)?;
        for step in steps {
            let list = |recorder: &mut Recorder| (step.stage.gpu)(&mut Pass::record(state, *step, self, recorder));
            if apart { list(&mut recorder)? } else { recorder.part_of(step.stage.name, step.place(), list)? }
        }
        self.execution().list(&mut recorder)?;
        let times = recorder.submit_again(self.recordings())?;
        self.execution().verify("running a frame")?;
        Ok(times)
    }

    /// How many dispatches these steps have.
    fn count(&self, state: &State, steps: &[Step]) -> Result<usize> {
        let mut seen = 0;
        for step in steps {
            let mut recorder = Recorder::new(self.device(), 0)?;
            let sink = Sink::Part(self, &mut recorder, OneOf { index: usize::MAX, seen: &mut seen });
            (step.stage.gpu)(&mut Pass { state, at: step.at, step: *step, sink })?;
        }
        Ok(seen)
    }

    /// Records and submits one dispatch of a step; returns its time under the name of the stage, and whether there are
    /// more after it.
    pub fn run_part(&self, state: &State, step: Step, index: usize) -> Result<(Option<Timing>, bool)> {
        let mut recorder = Recorder::new(self.device(), 1)?;
        let mut seen = 0;
        // Its time is not that of the step, and must not be taken for it.
        recorder.part_of(&format!("{} #{}", step.stage.name, index + 1), step.place(), |recorder| {
            let sink = Sink::Part(self, recorder, OneOf { index, seen: &mut seen });
            (step.stage.gpu)(&mut Pass { state, at: step.at, step, sink })
        })?;
        self.execution().list(&mut recorder)?;
        let times = recorder.submit_again(self.recordings())?;
        self.execution().verify("running a frame")?;
        let time = times.into_iter().next().map(|time| Timing { name: step.stage.name.to_string(), ..time });
        Ok((time, index + 1 < seen))
    }
}

impl<'s> Pass<'s> {
    /// The pass of a step on a device.
    pub(super) fn record(
        state: &'s State,
        step: Step,
        device_state: &'s DeviceState,
        recorder: &'s mut Recorder,
    ) -> Self {
        Self { state, at: step.at, step, sink: Sink::Device(device_state, recorder) }
    }

    /// The object at hand.
    pub fn object(&self) -> &'s Object {
        self.state.object(self.at)
    }

    /// What the device runs at once.
    pub fn width(&self) -> Width {
        match &self.sink {
            Sink::Device(device_state, _) | Sink::Part(device_state, ..) | Sink::Trace(device_state, ..) => {
                Width::of(device_state.device())
            }
            Sink::Ask(width, _) => *width,
        }
    }

    /// Runs the stage's only kernel, or its kernel of the name `part`, for `count` invocations.
    pub fn dispatch(&mut self, part: Option<&str>, constants: &[u32], push: &[u8], count: usize) -> Result<()> {
        self.submit(part, constants, push, Groups::Invocations(count))
    }

    /// Runs the stage's kernel `part` in this many groups, whatever their size.
    pub fn dispatch_groups(&mut self, part: &str, constants: &[u32], push: &[u8], count: usize) -> Result<()> {
        self.submit(Some(part), constants, push, Groups::Whole(count))
    }

    /// Runs kernel `part` indirectly, for as many work groups as this element of the buffer's part says (three
    /// numbers, written by an earlier dispatch), or the next element, if the kernel's groups have a block each.
    pub fn dispatch_counted(
        &mut self,
        part: &str,
        constants: &[u32],
        push: &[u8],
        (slot, element): (BufferId, usize),
    ) -> Result<()> {
        self.submit(Some(part), constants, push, Groups::Counted { slot, element })
    }

    fn submit(&mut self, part: Option<&str>, constants: &[u32], push: &[u8], groups: Groups) -> Result<()> {
        let kernel = self.kernel(part);
        match &mut self.sink {
            Sink::Device(device_state, recorder) => {
                let (state, call) = (self.state, Call { kernel: &kernel, constants, push, at: self.at, groups });
                let list = |recorder: &mut Recorder| device_state.submit(recorder, state, &call);
                match device_state.device().choices().timed {
                    Timed::Steps => list(recorder)?,
                    Timed::Kernels => recorder.part_of(&kernel, self.step.place(), list)?,
                    // What is not dispatched has no number.
                    Timed::Dispatches if matches!(groups, Groups::Invocations(0)) => {}
                    Timed::Dispatches => {
                        let name = recorder.numbered(&kernel);
                        recorder.part_of(&name, self.step.place(), list)?;
                    }
                }
            }
            Sink::Part(device_state, recorder, part) => {
                let here = part.index == *part.seen;
                *part.seen += 1;
                if here {
                    let call = Call { kernel: &kernel, constants, push, at: self.at, groups };
                    device_state.submit(recorder, self.state, &call)?;
                }
            }
            Sink::Trace(device_state, trace, way) => {
                let call = Call { kernel: &kernel, constants, push, at: self.at, groups };
                device_state.traced(self.state, &call, (trace, way))?;
            }
            Sink::Ask(_, told) => told(&Call { kernel: &kernel, constants, push, at: self.at, groups })?,
        }
        Ok(())
    }

    /// Runs the stage's kernel `part` for all clusters, children always before their parents: a dispatch for each
    /// level, or one for all where the kernel can and many invocations run at once.
    pub fn climb(&mut self, part: &str, constants: &[u32]) -> Result<()> {
        if self.climbs(part, constants)? {
            let faces = self.object().count.faces;
            let range = Range { first: 0, count: faces as u32 };
            return self.dispatch(Some(part), constants, bytemuck::bytes_of(&range), faces);
        }
        let levels = self.object().schedule.upward().map(in_order).collect::<Vec<_>>();
        levels.iter().try_for_each(|level| self.dispatch_level(part, constants, level))
    }

    /// Whether this kernel goes through all levels at once.
    fn climbs(&self, part: &str, constants: &[u32]) -> Result<bool> {
        match &self.sink {
            Sink::Device(device_state, _) | Sink::Part(device_state, ..) | Sink::Trace(device_state, ..) => {
                let kernel = device_state.kernels().get(&self.kernel(Some(part)), constants)?;
                Ok(kernel.lanes() > 1)
            }
            Sink::Ask(width, _) => Ok(width.shares),
        }
    }

    /// The name of the stage's only kernel, or of its kernel `part`.
    fn kernel(&self, part: Option<&str>) -> String {
        let (module, stage) = (self.step.stage.module, self.step.stage.name);
        match part {
            Some(part) => format!("{module}/{stage}/{part}"),
            None => format!("{module}/{stage}"),
        }
    }

    fn dispatch_level(&mut self, part: &str, constants: &[u32], level: &Range) -> Result<()> {
        self.dispatch(Some(part), constants, bytemuck::bytes_of(level), level.count as usize)
    }
}
