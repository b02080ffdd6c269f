//! From a step of a fixture to a [`Case`]: the reference runs up to the step, the device runs the step's dispatches one
//! at a time, and the reference says what they should have left.

use std::collections::BTreeMap;

use super::isolate::isolate;
use super::together::together;
use super::{ANY, About, BITS, Bound, Case, Dispatch, Part};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::{BUFFER_IDS, BufferId, Number};
use crate::measure::conform::poison;
use crate::measure::fixtures::Fixture;
use crate::measure::rules::Rules;
use crate::state::{DeviceState, Stage, State, Step, Tolerance, Trace, Traced, Width};

/// A step of a fixture before anything runs.
pub(super) struct Begun {
    step: Step,
    device_state: DeviceState,
    /// The reference's state before the step, and after it.
    before: State,
    after: State,
}

/// The step of this index; none where the fixture has no such step.
pub(super) fn begin(device: &Device, fixture: &Fixture, index: usize) -> Result<Option<Begun>> {
    let mut before = fixture.state.clone();
    let (done, rest) = fixture.steps.split_at(index.min(fixture.steps.len()));
    let Some(&step) = rest.first() else { return Ok(None) };
    done.iter().for_each(|step| step.reference(&mut before));
    poison(&mut before, step);
    let mut device_state = DeviceState::new(device, true)?;
    device_state.upload(&before, BUFFER_IDS)?;
    let mut after = before.clone();
    step.reference(&mut after);
    Ok(Some(Begun { step, device_state, before, after }))
}

impl Begun {
    /// All dispatches of the step, none of them run: their case, and their trace; none where there are none.
    pub(super) fn listed(&self, device: &Device, fixture: &Fixture) -> Result<Option<(Case, Trace)>> {
        let list = self.device_state.list(&self.before, self.step, &self.after)?;
        if list.dispatches.is_empty() {
            return Ok(None);
        }
        Ok(Some((self.whole(device, fixture, &list)?, list)))
    }

    /// Runs the dispatches one at a time; `told` gets those that have run, and the next one before it runs.
    pub(super) fn trace(&self, told: &mut dyn FnMut(&Trace, &Traced) -> Result<()>) -> Result<Trace> {
        self.device_state.trace(&self.before, self.step, told)
    }

    fn whole(&self, device: &Device, fixture: &Fixture, trace: &Trace) -> Result<Case> {
        whole(device, fixture, (self.step, &self.after), trace)
    }
}

/// The case of the step of this index in a fixture: those of its dispatches that a failure needs, or all of them if the
/// device is right. None if the step dispatches nothing.
pub fn case(device: &Device, fixture: &Fixture, index: usize) -> Result<Option<Case>> {
    let Some(begun) = begin(device, fixture, index)? else { return Ok(None) };
    let trace = begun.trace(&mut |_, _| Ok(()))?;
    if trace.dispatches.is_empty() {
        return Ok(None);
    }
    let whole = begun.whole(device, fixture, &trace)?;
    let left: Vec<_> = trace.dispatches.iter().map(|dispatch| left(&trace, dispatch)).collect();
    let case = isolate(whole, &left);
    // All are right one at a time: a failure may need them in one submission.
    if case.about.fails { Ok(Some(case)) } else { together(case, |case| case.run(device)).map(Some) }
}

/// The index of the first step of this stage that dispatches something on a device.
pub fn first_step(fixture: &Fixture, stage: &str, device: &Device) -> Result<Option<usize>> {
    for (index, step) in fixture.steps.iter().enumerate().filter(|(_, step)| step.stage.name == stage) {
        if !crate::state::dispatches(&fixture.state, &[*step], Width::of(device))?.is_empty() {
            return Ok(Some(index));
        }
    }
    Ok(None)
}

/// What a dispatch has left in the buffers that it may write, by their index among the parts of a trace.
pub(super) fn left(trace: &Trace, dispatch: &Traced) -> BTreeMap<usize, Vec<u32>> {
    let index = |slot: &BufferId| trace.parts.keys().position(|known| known == slot).unwrap_or_default();
    dispatch.after.iter().map(|(slot, bytes)| (index(slot), words(bytes))).collect()
}

/// The words of these bytes; buffers consist of whole words.
fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// Sets what the words of a buffer from word number `first` on may differ by; `state` is the reference after the stage.
fn allow(stage: &Stage, slot: BufferId, state: &State, first: usize, allowed: &mut [f32]) {
    if stage.is_scratch(slot) {
        allowed.fill(ANY);
    }
    let written = stage.writes.iter().find(|(written, _, _)| *written == slot);
    if let Some((_, _, tolerance)) = written.filter(|(_, _, tolerance)| *tolerance != Tolerance::Exact) {
        let rules = Rules::new(slot, state, *tolerance);
        for (k, allowed) in allowed.iter_mut().enumerate() {
            if let Some(most) = rules.at(first + k).most {
                *allowed = up(most);
            }
        }
    }
}

/// All dispatches of a step; `state` is the reference after it.
fn whole(device: &Device, fixture: &Fixture, (step, state): (Step, &State), trace: &Trace) -> Result<Case> {
    let stage = step.stage;
    let mut case = Case {
        about: About {
            stage: stage.name.into(),
            does: stage.about.into(),
            step: step.to_string(),
            fixture: fixture.name.clone(),
            device: device.name().into(),
            driver: device.driver().into(),
            tolerance: stage.reason.into(),
            ..About::default()
        },
        ..Case::default()
    };
    for (slot, (first, before)) in &trace.parts {
        let spec = slot.spec();
        let path = |word: crate::layout::Word| (word.path, word.number == Number::Float);
        let mut part = Part {
            name: spec.name.into(),
            words: (spec.words)().into_iter().map(path).collect(),
            first: *first as usize / spec.stride,
            before: words(before),
            ..Part::default()
        };
        // The reference has no guard bytes: they must stay as they are.
        let own = words(state.data.bytes(*slot).get(*first as usize..).unwrap_or_default());
        part.expected = part.before.clone();
        let (_, bound) = state.part(*slot, step.at);
        let count = (bound * spec.stride / 4).min(own.len()).min(part.before.len());
        part.expected[..count].copy_from_slice(&own[..count]);
        part.allowed = vec![BITS; part.before.len()];
        allow(stage, *slot, state, *first as usize / 4, &mut part.allowed[..count]);
        part.device = part.before.clone();
        case.buffers.push(part);
    }
    for dispatch in &trace.dispatches {
        let index = |slot: &BufferId| trace.parts.keys().position(|known| known == slot).unwrap_or_default();
        case.dispatches.push(Dispatch {
            kernel: dispatch.kernel.clone(),
            spirv: device.words(&dispatch.kernel)?,
            constants: dispatch.constants.clone(),
            push: words(&dispatch.push),
            lanes: dispatch.lanes,
            groups: dispatch.groups,
            first_group: 0,
            bindings: dispatch
                .bindings
                .iter()
                .map(|b| Bound { number: b.number, buffer: index(&b.slot), bytes: b.bytes, writes: b.writes })
                .collect(),
        });
    }
    Ok(case)
}

/// The least `f32` that is not below; a value that is not finite, as from poison that stays, allows only the same bits.
fn up(value: f64) -> f32 {
    if !value.is_finite() {
        return BITS;
    }
    let near = value as f32;
    if f64::from(near) < value { near.next_up() } else { near }
}
