//! What each dispatch of a step was given and what it left, for a copy of it that runs elsewhere.

use std::collections::BTreeMap;

use super::State;
use super::device::{Call, DeviceState, Groups};
use crate::error::Result;
use crate::gpu::{BufferRange, Recorder, Work, download};
use crate::layout::BufferId;

/// The dispatches of a step, one at a time. All of them bind the same part of a buffer.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The first byte of each buffer's part, and the part's bytes before the first dispatch that binds it; those of
    /// guards follow where any dispatch binds them.
    pub parts: BTreeMap<BufferId, (u64, Vec<u8>)>,
    /// The dispatches, in order; those of no group are left out.
    pub dispatches: Vec<Traced>,
}

/// A dispatch.
#[derive(Clone, Debug)]
pub struct Traced {
    /// The kernel, `transport/blocks/gather/direct`.
    pub kernel: String,
    /// Its specialization constants 0, 1, ...
    pub constants: Vec<u32>,
    /// Its push constants.
    pub push: Vec<u8>,
    /// Invocations that share an item.
    pub lanes: u32,
    /// Groups in each dimension; those of an indirect dispatch as the device, or the reference, counts them.
    pub groups: [u32; 3],
    /// What it binds.
    pub bindings: Vec<TracedBinding>,
    /// The parts that it may write, as it left them if it was run.
    pub after: Vec<(BufferId, Vec<u8>)>,
}

/// A buffer as a dispatch binds it.
#[derive(Clone, Copy, Debug)]
pub struct TracedBinding {
    /// The binding.
    pub number: u32,
    /// The buffer.
    pub slot: BufferId,
    /// Bytes bound, from the first one of the part.
    pub bytes: u64,
    /// Whether it is read.
    pub reads: bool,
    /// Whether it is written.
    pub writes: bool,
}

/// How dispatches are traced.
pub(super) enum Way<'a> {
    /// Each is run, after this is told of it and those before it.
    Run(&'a mut dyn FnMut(&Trace, &Traced) -> Result<()>),
    /// None is. Indirect ones have as many groups as this state says, of the reference after the step.
    List(&'a State),
}

impl DeviceState {
    /// Adds one dispatch to the trace.
    pub(super) fn traced(
        &self,
        state: &State,
        call: &Call<'_>,
        (trace, way): (&mut Trace, &mut Way<'_>),
    ) -> Result<()> {
        let kernel = self.kernels().get(call.kernel, call.constants)?;
        let bound: Vec<_> = self.bound(&kernel, state, call.at).collect();
        let groups = match call.groups {
            Groups::Invocations(count) => kernel.grid(count as u64),
            Groups::Whole(count) => [count as u32, 1, 1],
            Groups::Counted { slot, element } => {
                let range = self.counted(state, call.at, &kernel, (slot, element));
                range.map_or(Ok([0; 3]), |range| self.read_groups((slot, range), way))?
            }
        };
        if groups.contains(&0) {
            return Ok(());
        }
        let mut dispatch = Traced {
            kernel: call.kernel.to_string(),
            constants: call.constants.to_vec(),
            push: call.push.to_vec(),
            lanes: kernel.lanes(),
            groups,
            bindings: Vec::new(),
            after: Vec::new(),
        };
        for ((slot, binding), access) in bound.iter().zip(&kernel.accesses) {
            let part = trace.parts.entry(*slot).or_insert_with(|| (binding.offset, Vec::new()));
            if (part.1.len() as u64) < binding.size {
                // An earlier dispatch binds less, and has not touched the rest.
                let known = part.1.len() as u64;
                let (offset, size) = (binding.offset + known, binding.size - known);
                part.1.extend(self.read(BufferRange { buffer: binding.buffer, offset, size })?);
            }
            let (reads, writes) = (access.reads, access.writes);
            dispatch.bindings.push(TracedBinding {
                number: binding.number,
                slot: *slot,
                bytes: binding.size,
                reads,
                writes,
            });
        }
        let Way::Run(told) = way else {
            trace.dispatches.push(dispatch);
            return Ok(());
        };
        told(trace, &dispatch)?;
        let bindings: Vec<_> = bound.iter().map(|(_, binding)| *binding).collect();
        let mut recorder = Recorder::new(self.device(), 0)?;
        recorder.part(call.kernel, |recorder| recorder.dispatch(&kernel, &bindings, call.push, Work::Grid(groups)))?;
        recorder.submit()?;
        for ((slot, binding), own) in bound.iter().zip(&dispatch.bindings) {
            if own.writes && !dispatch.after.iter().any(|(known, _)| known == slot) {
                let range = BufferRange { buffer: binding.buffer, offset: binding.offset, size: binding.size };
                dispatch.after.push((*slot, self.read(range)?));
            }
        }
        trace.dispatches.push(dispatch);
        Ok(())
    }

    /// The groups of an indirect dispatch that this part of a buffer counts.
    fn read_groups(&self, (slot, range): (BufferId, BufferRange<'_>), way: &Way<'_>) -> Result<[u32; 3]> {
        Ok(match way {
            Way::Run(_) => bytemuck::pod_read_unaligned(&self.read(range)?),
            Way::List(after) => {
                let bytes = after.data.bytes(slot).get(range.offset as usize..).unwrap_or_default();
                bytes.get(..12).map_or([0; 3], bytemuck::pod_read_unaligned)
            }
        })
    }

    /// The bytes of a part of a buffer.
    fn read(&self, range: BufferRange<'_>) -> Result<Vec<u8>> {
        let mut bytes = vec![0; range.size as usize];
        download(self.device(), &[range], |part| {
            bytes[part.offset..part.offset + part.bytes.len()].copy_from_slice(part.bytes);
        })?;
        Ok(bytes)
    }
}
