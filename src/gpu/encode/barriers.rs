//! What keeps dispatches that depend on each other in order: barriers or events.

use ash::vk;

use super::Encoded;
use crate::error::Result;
use crate::gpu::call::vk_call;
use crate::gpu::choices::Barriers;
use crate::gpu::list::BoundRange;
use crate::gpu::order::Wait;

/// The stages that a barrier between dispatches orders.
pub(super) const STAGES: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::COMPUTE_SHADER.as_raw() | vk::PipelineStageFlags::DRAW_INDIRECT.as_raw(),
);
const SEEN: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::SHADER_READ.as_raw()
        | vk::AccessFlags::SHADER_WRITE.as_raw()
        | vk::AccessFlags::INDIRECT_COMMAND_READ.as_raw(),
);

impl Encoded {
    /// Makes the events that dispatches wait for.
    pub(super) fn make_events(&mut self, waits: &[Option<Wait>], dispatches: usize) -> Result<()> {
        if self.device.choices().barriers != Barriers::Events {
            return Ok(());
        }
        self.events = vec![vk::Event::null(); dispatches];
        for wait in waits.iter().flatten() {
            if self.events[wait.after] == vk::Event::null() {
                // SAFETY: the device is alive; events are freed with the recording.
                self.events[wait.after] = vk_call("vkCreateEvent", "recording a frame", || unsafe {
                    self.device.raw().create_event(&vk::EventCreateInfo::default(), None)
                })?;
                self.device.label(self.events[wait.after], format_args!("after dispatch {}", wait.after));
            }
        }
        Ok(())
    }

    /// Records, at the end, that copies and the host see what kernels have written, and may write after them.
    pub(super) fn make_visible(&self) {
        let seen = vk::AccessFlags::TRANSFER_READ
            | vk::AccessFlags::TRANSFER_WRITE
            | vk::AccessFlags::HOST_READ
            | vk::AccessFlags::HOST_WRITE;
        let memory =
            [vk::MemoryBarrier::default().src_access_mask(vk::AccessFlags::SHADER_WRITE).dst_access_mask(seen)];
        let after = vk::PipelineStageFlags::TRANSFER | vk::PipelineStageFlags::HOST;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording.
        unsafe { self.device.raw().cmd_pipeline_barrier(self.now, STAGES, after, none, &memory, &[], &[]) };
    }

    /// Records a copy that waits for all dispatches before it, and all after it wait for it.
    pub(super) fn copy(&self, [from, to]: &[BoundRange; 2]) {
        let moved = vk::AccessFlags::TRANSFER_READ | vk::AccessFlags::TRANSFER_WRITE;
        let barrier = |before: vk::AccessFlags, after: vk::AccessFlags| {
            [vk::MemoryBarrier::default().src_access_mask(before).dst_access_mask(after)]
        };
        let before = barrier(vk::AccessFlags::SHADER_WRITE | moved, moved);
        let after = barrier(vk::AccessFlags::TRANSFER_WRITE, SEEN | vk::AccessFlags::SHADER_WRITE);
        let region = [vk::BufferCopy { src_offset: from.offset, dst_offset: to.offset, size: to.size }];
        let (raw, copies) = (self.device.raw(), vk::PipelineStageFlags::TRANSFER);
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording; the buffers are alive, and the ranges lie within them.
        unsafe {
            raw.cmd_pipeline_barrier(self.now, STAGES | copies, copies, none, &before, &[], &[]);
            raw.cmd_copy_buffer(self.now, from.buffer, to.buffer, &region);
            raw.cmd_pipeline_barrier(self.now, copies, STAGES, none, &after, &[], &[]);
        }
    }

    /// Records that what follows waits.
    pub(super) fn wait(&self, wait: &Wait) {
        let raw = self.device.raw();
        let memory =
            [vk::MemoryBarrier::default().src_access_mask(vk::AccessFlags::SHADER_WRITE).dst_access_mask(SEEN)];
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording; buffers and events are alive.
        unsafe {
            match self.device.choices().barriers {
                Barriers::Elided | Barriers::Every => {
                    raw.cmd_pipeline_barrier(self.now, STAGES, STAGES, none, &memory, &[], &[]);
                }
                Barriers::Buffer => {
                    let buffers: Vec<_> = wait.buffers.iter().map(|buffer| barrier_of(*buffer)).collect();
                    raw.cmd_pipeline_barrier(self.now, STAGES, STAGES, none, &[], &buffers, &[]);
                }
                Barriers::Events => {
                    raw.cmd_wait_events(self.now, &[self.events[wait.after]], STAGES, STAGES, &memory, &[], &[]);
                }
                Barriers::Synchronization2 => {
                    let stages = vk::PipelineStageFlags2::COMPUTE_SHADER | vk::PipelineStageFlags2::DRAW_INDIRECT;
                    let seen = vk::AccessFlags2::SHADER_READ
                        | vk::AccessFlags2::SHADER_WRITE
                        | vk::AccessFlags2::INDIRECT_COMMAND_READ;
                    let memory = [vk::MemoryBarrier2::default()
                        .src_stage_mask(stages)
                        .src_access_mask(vk::AccessFlags2::SHADER_WRITE)
                        .dst_stage_mask(stages)
                        .dst_access_mask(seen)];
                    let info = vk::DependencyInfo::default().memory_barriers(&memory);
                    self.device.synchronization2().cmd_pipeline_barrier2(self.now, &info);
                }
            }
        }
    }
}

/// A barrier for a whole buffer.
fn barrier_of(buffer: vk::Buffer) -> vk::BufferMemoryBarrier<'static> {
    vk::BufferMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::SHADER_WRITE)
        .dst_access_mask(SEEN)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .buffer(buffer)
        .size(vk::WHOLE_SIZE)
}
