//! Running a case on a device, and comparing what it leaves.

use std::collections::BTreeMap;
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use super::{Case, Dispatch, Part};
use crate::error::{Input, Result};
use crate::gpu::{Binding, Buffer, Device, Kernel, Recorder, Work, set_by_device, shifted};
use crate::measure::interpret::stage::SUBGROUP;
use crate::measure::interpret::{self, Launched, MOST_BLOCKS, Memory, Part as Bound};

/// The result of a case on a device.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Found {
    /// Wrong words of each buffer that has any: the buffer's name, their number, and the first of them in words.
    pub wrong: Vec<(String, usize, String)>,
    /// Words that were compared.
    pub words: usize,
    /// The messages of the validation layer.
    pub messages: Vec<String>,
}

impl Found {
    /// Whether everything was as it should be.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.wrong.is_empty() && self.messages.is_empty()
    }
}

impl Case {
    /// Runs the dispatches on a device, in one submission, and returns what they leave in each buffer.
    pub fn run(&self, device: &Device) -> Result<Vec<Vec<u32>>> {
        self.run_with(device, &[])
    }

    /// Like [`Self::run`], with one more buffer bound in each dispatch.
    pub(super) fn run_with(&self, device: &Device, more: &[(u32, Buffer)]) -> Result<Vec<Vec<u32>>> {
        let mut buffers = Vec::with_capacity(self.buffers.len());
        for part in &self.buffers {
            let buffer = Buffer::new(device, &part.name, 4 * part.before.len() as u64)?;
            buffer.upload(bytemuck::cast_slice(&part.before))?;
            buffers.push(buffer);
        }
        let mut kernels = BTreeMap::new();
        let mut recorder = Recorder::new(device, 0)?;
        for (index, dispatch) in self.dispatches.iter().enumerate() {
            let key = (&dispatch.kernel, &dispatch.constants, &dispatch.spirv, dispatch.lanes);
            let kernel = match kernels.get(&key) {
                Some(known) => Rc::clone(known),
                None => {
                    let words = dispatch.spirv.clone();
                    let (name, constants) = (&dispatch.kernel, &dispatch.constants);
                    let made = Rc::new(Kernel::with_lanes(device, name, words, constants, dispatch.lanes)?);
                    kernels.insert(key, made.clone());
                    made
                }
            };
            let bind =
                |b: &super::Bound| Binding { number: b.number, buffer: &buffers[b.buffer], offset: 0, size: b.bytes };
            let mut bindings: Vec<_> = dispatch.bindings.iter().map(bind).collect();
            if let Some((number, buffer)) = more.get(index) {
                bindings.push(Binding { number: *number, buffer, offset: 0, size: buffer.size() });
            }
            let push = bytemuck::cast_slice(&dispatch.push);
            recorder.part(&dispatch.kernel, |recorder| {
                recorder.dispatch(&kernel, &bindings, push, Work::Grid(dispatch.groups))
            })?;
        }
        recorder.submit()?;
        let mut left = Vec::with_capacity(buffers.len());
        for (part, buffer) in self.buffers.iter().zip(&buffers) {
            let mut words = part.before.clone();
            buffer.download(bytemuck::cast_slice_mut(&mut words))?;
            left.push(words);
        }
        Ok(left)
    }

    /// Runs the case this many times, and compares each time; stops at the first run with a difference or a message.
    pub fn replay(&self, device: &Device, times: usize) -> Result<Found> {
        let mut found = Found::default();
        let able = |device: Device, dispatch: &Dispatch| device.able(&dispatch.kernel, &dispatch.spirv);
        let device = &self.dispatches.iter().try_fold(device.clone(), able)?;
        for time in 0..times.max(1) {
            let left = self.run(device)?;
            found = self.compare(&left);
            found.messages = device.take_messages();
            if !found.passes() {
                if time > 0 {
                    found.wrong.iter_mut().for_each(|(_, _, first)| *first += &format!("; only in run {}", time + 1));
                }
                break;
            }
        }
        Ok(found)
    }

    /// Runs the case on the interpreter of kernels, once, since it always does the same; and compares.
    pub fn interpreted(&self) -> Result<Found> {
        let memory = |part: &Part| Memory::of(bytemuck::cast_slice(&part.before));
        let buffers: Vec<Memory> = self.buffers.iter().map(memory).collect();
        let memory = &buffers.iter().collect::<Vec<_>>()[..];
        for Dispatch { kernel, spirv, constants, push, lanes, groups, bindings, .. } in &self.dispatches {
            let shape = set_by_device(kernel, spirv, (*lanes).max(1));
            let special = (0..).zip(constants.iter().copied()).chain(shape).collect();
            let part = |b: &super::Bound| Bound { memory: b.buffer, first: 0, count: b.bytes as usize / 4 };
            let bound = &bindings.iter().map(|b| (b.number, part(b))).collect();
            let (groups, push) = (*groups, bytemuck::cast_slice(push));
            let launched = Launched { groups, push, bound, memory, subgroup: SUBGROUP, most_blocks: MOST_BLOCKS };
            interpret::Kernel::new(kernel, spirv, &special)?.run(&launched)?;
        }
        let mut left: Vec<Vec<u32>> = self.buffers.iter().map(|part| part.before.clone()).collect();
        buffers.iter().zip(&mut left).for_each(|(memory, words)| memory.write(bytemuck::cast_slice_mut(words)));
        Ok(self.compare(&left))
    }

    /// Compares what a device has left with what it should have.
    #[must_use]
    pub fn compare(&self, left: &[Vec<u32>]) -> Found {
        let mut found = Found::default();
        for (part, words) in self.buffers.iter().zip(left) {
            found.words += part.compared();
            let wrong: Vec<usize> = part.wrong(words).collect();
            if let Some(&first) = wrong.first() {
                let text = format!("{}: {}", part.place(first), part.values(first, words[first]));
                found.wrong.push((part.name.clone(), wrong.len(), text));
            }
        }
        found
    }

    /// The case with other SPIR-V in place of a kernel's, where it runs that kernel.
    pub fn replacing(mut self, kernel: &str, words: &[u32]) -> Result<Self> {
        for dispatch in self.dispatches.iter_mut().filter(|dispatch| dispatch.kernel == kernel) {
            dispatch.spirv = match dispatch.first_group {
                0 => words.to_vec(),
                first => shifted(words, first).ok_or_else(|| {
                    let what = format!("its groups can't begin at {first}, as in this case");
                    Input::new(what).key("--replace").found(kernel)
                })?,
            };
        }
        Ok(self)
    }
}

impl Part {
    /// How many words are compared.
    #[must_use]
    pub fn compared(&self) -> usize {
        self.allowed.iter().filter(|allowed| **allowed != super::ANY).count()
    }
}
