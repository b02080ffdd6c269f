//! The state's copy on a device: one buffer per buffer id, and the recording of a stage's dispatches.

use std::collections::BTreeMap;

use super::{Scope, State};
use crate::error::Result;
use crate::gpu::{
    Binding, Buffer, BufferRange, Device, ExecutionCheck, Kernel, Kernels, Recorder, Recordings, Upload, Work,
    download, upload,
};
use crate::layout::{BUFFER_IDS, BufferId};

/// Guard bytes after the end of each buffer of a guarded state, which no kernel may touch. As many bytes after a part
/// are bound along with it.
const GUARD: u64 = 64;
/// The value of each guard byte.
const GUARD_BYTE: u8 = 0xA5;

/// The buffers and kernels of one device.
pub struct DeviceState {
    device: Device,
    pub(super) kernels: Kernels,
    buffers: BTreeMap<BufferId, Buffer>,
    /// Bound where a kernel names a buffer that has no elements in this scene.
    nothing: Box<Buffer>,
    recordings: Recordings,
    execution: Box<ExecutionCheck>,
    guarded: bool,
}

impl DeviceState {
    /// The copy of a state, without buffers yet. With `guarded`, every buffer is followed by bytes that
    /// [`Self::trespasses`] checks.
    pub fn new(device: &Device, guarded: bool) -> Result<Self> {
        let nothing = Box::new(Buffer::new(device, "nothing", 1 << 18)?);
        let (kernels, recordings) = (Kernels::new(device), Recordings::default());
        let (execution, device) = (Box::new(ExecutionCheck::new(device)?), device.clone());
        Ok(Self { device, kernels, buffers: BTreeMap::new(), nothing, recordings, execution, guarded })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Recordings of earlier frames.
    pub(super) fn recordings(&self) -> &Recordings {
        &self.recordings
    }

    /// The check that the device executes a frame.
    pub(super) fn execution(&self) -> &ExecutionCheck {
        &self.execution
    }

    /// Makes every buffer as large as the state's; contents survive only where the size is unchanged. An empty buffer
    /// is not allocated unless guarded.
    pub fn resize(&mut self, state: &State) -> Result<()> {
        let mut made = Vec::new();
        for &id in BUFFER_IDS {
            let size = state.data.bytes(id).len() as u64;
            if size == 0 && !self.guarded {
                self.buffers.remove(&id);
                continue;
            }
            let whole = if self.guarded { size.next_multiple_of(4) + GUARD } else { size };
            if self.buffers.get(&id).is_some_and(|buffer| buffer.size() == whole) {
                continue;
            }
            self.buffers.remove(&id);
            self.buffers.insert(id, Buffer::new(&self.device, id.spec().name, whole)?);
            made.push(id);
        }
        if !made.is_empty() {
            self.recordings.clear();
        }
        if let Some(byte) = self.device.choices().fill {
            let sizes = made.iter().map(|id| self.buffers[id].size() as usize);
            let bytes = vec![byte; sizes.max().unwrap_or(0)];
            let fill = |id: &BufferId| {
                let buffer = &self.buffers[id];
                Upload { buffer, offset: 0, bytes: &bytes[..buffer.size() as usize] }
            };
            upload(&self.device, &made.iter().map(fill).collect::<Vec<_>>())?;
        }
        let guards = self.guards(state, &made);
        let bytes = [GUARD_BYTE; GUARD as usize + 4];
        let fill: Vec<_> = guards
            .iter()
            .map(|&BufferRange { buffer, offset, size }| Upload { buffer, offset, bytes: &bytes[..size as usize] })
            .collect();
        upload(&self.device, &fill)
    }

    /// The guard bytes after the end of these buffers; none where buffers are not guarded.
    fn guards(&self, state: &State, ids: &[BufferId]) -> Vec<BufferRange<'_>> {
        let guard = |id: &BufferId| {
            let (buffer, used) = (self.buffers.get(id)?, state.data.bytes(*id).len() as u64);
            Some(BufferRange { buffer, offset: used, size: buffer.size().saturating_sub(used) })
        };
        ids.iter().filter(|_| self.guarded).filter_map(guard).collect()
    }

    /// Copies these buffers of the state to the device.
    pub fn upload(&mut self, state: &State, ids: &[BufferId]) -> Result<()> {
        self.resize(state)?;
        let fill =
            |id: &BufferId| Some(Upload { buffer: self.buffers.get(id)?, offset: 0, bytes: state.data.bytes(*id) });
        upload(&self.device, &ids.iter().filter_map(fill).collect::<Vec<_>>())
    }

    /// Copies these buffers of the device to the state.
    pub fn download(&self, state: &mut State, ids: &[BufferId]) -> Result<()> {
        let ids: Vec<BufferId> = ids.iter().copied().filter(|id| self.buffers.contains_key(id)).collect();
        let range = |id: &BufferId| {
            let size = state.data.bytes(*id).len() as u64;
            BufferRange { buffer: &self.buffers[id], offset: 0, size }
        };
        let ranges: Vec<_> = ids.iter().map(range).collect();
        download(&self.device, &ranges, |part| {
            let end = part.offset + part.bytes.len();
            state.data.bytes_mut(ids[part.range])[part.offset..end].copy_from_slice(part.bytes);
        })
    }

    /// The names of guarded buffers whose guard was overwritten.
    pub fn trespasses(&self, state: &State) -> Result<Vec<&'static str>> {
        let ids: Vec<BufferId> = self.buffers.keys().copied().collect();
        let mut found = vec![false; ids.len()];
        download(&self.device, &self.guards(state, &ids), |part| {
            found[part.range] |= part.bytes.iter().any(|&byte| byte != GUARD_BYTE);
        })?;
        Ok(ids.iter().zip(found).filter(|(_, found)| *found).map(|(id, _)| id.spec().name).collect())
    }

    /// The kernels created so far, and what they have done where they count it.
    pub fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// The allocated buffers with their sizes in bytes, without the placeholder for empty ones.
    pub fn buffers(&self) -> impl Iterator<Item = (BufferId, u64)> + '_ {
        self.buffers.iter().map(|(id, buffer)| (*id, buffer.size()))
    }

    /// A buffer, if it is allocated.
    pub fn buffer(&self, id: BufferId) -> Option<&Buffer> {
        self.buffers.get(&id)
    }

    /// Records one dispatch of a kernel; each buffer is bound to its part for the scope of the call.
    pub(super) fn submit(&self, recorder: &mut Recorder, state: &State, call: &Call<'_>) -> Result<()> {
        let kernel = self.kernels.get(call.kernel, call.constants)?;
        let bindings: Vec<Binding<'_>> = self.bound(&kernel, state, call.at).map(|(_, binding)| binding).collect();
        let work = match call.groups {
            Groups::Invocations(count) => Work::Invocations(count as u64),
            Groups::Whole(count) => Work::Grid([count as u32, 1, 1]),
            Groups::Counted { slot, element } => match self.counted(state, call.at, &kernel, (slot, element)) {
                Some(BufferRange { buffer, offset, .. }) => Work::Groups { buffer, offset },
                None => return Ok(()),
            },
        };
        recorder.dispatch(&kernel, &bindings, call.push, work)
    }

    /// What a kernel binds in this scope: each buffer's part, and which buffer it is.
    pub(super) fn bound<'a>(
        &'a self,
        kernel: &'a Kernel,
        state: &'a State,
        at: Scope,
    ) -> impl Iterator<Item = (BufferId, Binding<'a>)> {
        kernel.accesses.iter().filter_map(move |access| {
            let id = state.data.bound(*BUFFER_IDS.get(access.binding as usize)?);
            let Some(buffer) = self.buffers.get(&id) else {
                return Some((id, Binding { number: access.binding, buffer: &self.nothing, offset: 0, size: 0 }));
            };
            let stride = id.spec().stride as u64;
            let (first, count) = state.part(id, at);
            let (offset, needed) = (first as u64 * stride, (count as u64 * stride).max(4));
            // A driver drops writes beyond what is bound. What follows the part is bound too where it is guarded, so
            // that they show; not where the kernel goes by the number of elements that are bound.
            let guard = if self.guarded && access.writes && !access.asks_length { GUARD } else { 0 };
            let most = (buffer.size() - offset).min(self.device.limits().binding_bytes);
            let size = (needed + guard).min(most).max(needed);
            Some((id, Binding { number: access.binding, buffer, offset, size }))
        })
    }

    /// Where the three numbers of an indirect dispatch are: in the next element for a kernel whose groups have a block
    /// each.
    pub(super) fn counted(
        &self,
        state: &State,
        at: Scope,
        kernel: &Kernel,
        (id, element): (BufferId, usize),
    ) -> Option<BufferRange<'_>> {
        let element = element + usize::from(kernel.lanes() > 1);
        let offset = ((state.part(id, at).0 + element) * id.spec().stride) as u64;
        Some(BufferRange { buffer: self.buffers.get(&id)?, offset, size: 12 })
    }
}

/// A dispatch that a stage requests.
pub struct Call<'a> {
    /// The kernel, `transport/blocks/gather/direct`.
    pub kernel: &'a str,
    /// Its specialization constants 0, 1, ...
    pub constants: &'a [u32],
    /// Its push constants.
    pub push: &'a [u8],
    /// The scope.
    pub at: Scope,
    /// How large it is.
    pub groups: Groups,
}

/// How large a dispatch is.
#[derive(Clone, Copy)]
pub enum Groups {
    /// This many invocations.
    Invocations(usize),
    /// This many groups.
    Whole(usize),
    /// Indirect: as many work groups as this element of the buffer's part says (three numbers, written by an earlier
    /// dispatch).
    Counted {
        /// The buffer.
        slot: BufferId,
        /// The element, counted from the beginning of its part.
        element: usize,
    },
}
