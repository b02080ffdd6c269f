//! The state's twin on a device: one buffer a slot, and the recording of a stage's dispatches.

use std::collections::BTreeMap;

use super::{Object, Place, State, Step};
use crate::error::Result;
use crate::gpu::{Binding, Buffer, Device, Kernels, Recorder, Timing, Work};
use crate::layout::{Range, SLOTS, Slot};

/// Bytes after the end of each buffer that no kernel may touch, when guarded.
const GUARD: u64 = 64;
/// What they hold.
const GUARD_BYTE: u8 = 0xA5;

/// The buffers and kernels of one device.
pub struct DeviceState {
    device: Device,
    kernels: Kernels,
    buffers: BTreeMap<Slot, Buffer>,
    guarded: bool,
}

/// What a stage records its dispatches with.
pub struct Pass<'a> {
    /// The host's state: sizes, schedule and settings only; its contents may be older than the device's.
    pub state: &'a State,
    /// The part of the work at hand.
    pub at: Place,
    twin: &'a DeviceState,
    recorder: &'a mut Recorder,
    room: &'static str,
    stage: &'static str,
}

impl DeviceState {
    /// No buffers yet. With `guarded`, every buffer is followed by bytes that [`Self::trespasses`] checks.
    pub fn new(device: &Device, guarded: bool) -> Self {
        Self { device: device.clone(), kernels: Kernels::new(device), buffers: BTreeMap::new(), guarded }
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Makes every buffer as large as the state's; contents survive only where the size is unchanged.
    pub fn resize(&mut self, state: &State) -> Result<()> {
        for &slot in SLOTS {
            let size = (state.data.bytes(slot).len() as u64).max(4);
            let whole = if self.guarded { size.next_multiple_of(4) + GUARD } else { size };
            if self.buffers.get(&slot).is_some_and(|buffer| buffer.size() == whole) {
                continue;
            }
            self.buffers.remove(&slot);
            self.buffers.insert(slot, Buffer::new(&self.device, slot.spec().name, whole)?);
        }
        Ok(())
    }

    /// Copies these buffers of the state to the device.
    pub fn upload(&mut self, state: &State, slots: &[Slot]) -> Result<()> {
        self.resize(state)?;
        for slot in slots {
            let bytes = state.data.bytes(*slot);
            let Some(buffer) = self.buffers.get(slot) else { continue };
            if self.guarded {
                let mut guarded = bytes.to_vec();
                guarded.resize(buffer.size() as usize, GUARD_BYTE);
                buffer.upload(&guarded)?;
            } else {
                buffer.upload(bytes)?;
            }
        }
        Ok(())
    }

    /// Copies these buffers of the device to the state.
    pub fn download(&self, state: &mut State, slots: &[Slot]) -> Result<()> {
        for slot in slots {
            if let Some(buffer) = self.buffers.get(slot) {
                buffer.download(state.data.bytes_mut(*slot))?;
            }
        }
        Ok(())
    }

    /// The names of guarded buffers whose guard was overwritten.
    pub fn trespasses(&self, state: &State) -> Result<Vec<&'static str>> {
        let mut found = Vec::new();
        for (slot, buffer) in self.buffers.iter().filter(|_| self.guarded) {
            let mut bytes = vec![0; buffer.size() as usize];
            buffer.download(&mut bytes)?;
            let used = state.data.bytes(*slot).len();
            if bytes[used..].iter().any(|&b| b != GUARD_BYTE) {
                found.push(slot.spec().name);
            }
        }
        Ok(found)
    }

    /// Records and submits these steps as one frame; returns the time of each.
    pub fn run(&self, state: &State, steps: &[Step]) -> Result<Vec<Timing>> {
        let mut recorder = Recorder::new(&self.device, steps.len())?;
        for step in steps {
            recorder.part(step.stage.name, |recorder| {
                let (room, stage) = (step.stage.room, step.stage.name);
                (step.stage.gpu)(&mut Pass { state, at: step.at, twin: self, recorder, room, stage })
            })?;
        }
        recorder.submit()
    }
}

impl<'s> Pass<'s> {
    /// The object at hand.
    pub fn object(&self) -> &'s Object {
        self.state.object(self.at)
    }

    /// Invocations that run in lockstep on the device.
    pub fn subgroup(&self) -> usize {
        self.twin.device.limits().subgroup_size.max(1) as usize
    }

    /// Runs the stage's own kernel for `count` invocations, or its kernel of the name `part`.
    pub fn dispatch(&mut self, part: Option<&str>, constants: &[u32], push: &[u8], count: usize) -> Result<()> {
        let name = match part {
            Some(part) => format!("{}/{}/{part}", self.room, self.stage),
            None => format!("{}/{}", self.room, self.stage),
        };
        self.submit(&name, constants, push, Work::Invocations(count as u64))
    }

    /// The same for as many groups as this element of this buffer's part says: three numbers, written earlier.
    pub fn dispatch_counted(
        &mut self,
        part: &str,
        constants: &[u32],
        push: &[u8],
        (groups, element): (Slot, usize),
    ) -> Result<()> {
        let name = format!("{}/{}/{part}", self.room, self.stage);
        let Some(buffer) = self.twin.buffers.get(&groups) else { return Ok(()) };
        let offset = (self.state.part(groups, self.at).0 + element) * groups.spec().stride;
        self.submit(&name, constants, push, Work::Groups(buffer, offset as u64))
    }

    fn submit(&mut self, name: &str, constants: &[u32], push: &[u8], work: Work<'_>) -> Result<()> {
        let kernel = self.twin.kernels.get(name, constants)?;
        let mut bindings = Vec::with_capacity(kernel.accesses.len());
        for access in &kernel.accesses {
            let Some(&slot) = SLOTS.get(access.binding as usize) else { continue };
            let Some(buffer) = self.twin.buffers.get(&slot) else { continue };
            let stride = slot.spec().stride as u64;
            let (first, count) = self.state.part(slot, self.at);
            bindings.push(Binding {
                number: access.binding,
                buffer,
                offset: first as u64 * stride,
                size: (count as u64 * stride).max(4),
            });
        }
        self.recorder.dispatch(&kernel, &bindings, push, work)
    }

    /// Runs the stage's kernel `part` once a level of the tree, children always before their parents.
    pub fn climb(&mut self, part: &str, constants: &[u32]) -> Result<()> {
        for level in self.object().schedule.upward() {
            let range = Range { first: level.start, count: level.end - level.start };
            self.dispatch(Some(part), constants, bytemuck::bytes_of(&range), range.count as usize)?;
        }
        Ok(())
    }
}
