//! Command buffers of a device, and what happens when one is submitted: a wait of limited length.

use std::time::{Duration, Instant};

use ash::vk;

use super::{Inner, LogicalDevice};
use crate::error::{Error, Result};
use crate::gpu::call::vk_call;
use crate::gpu::choices::Waiting;

/// How much longer to wait for a submission that exceeded its limit, before what it uses is freed. Software drivers
/// compile kernels in their first submission, which takes seconds on a busy machine.
pub(super) const GRACE: Duration = Duration::from_secs(10);

/// How long to ask for the end of a submission again and again, before sleeping.
const AWAKE: Duration = Duration::from_millis(20);

impl LogicalDevice {
    /// Submits one recorded command buffer and waits for it.
    pub(in super::super) fn submit(&self, commands: vk::CommandBuffer, doing: &str) -> Result<()> {
        self.submit_all(&[commands], doing)
    }

    /// Submits recorded command buffers one by one, and waits for the last.
    pub(in super::super) fn submit_all(&self, commands: &[vk::CommandBuffer], doing: &str) -> Result<()> {
        let infos: Vec<_> =
            commands.chunks(1).map(|buffers| vk::SubmitInfo::default().command_buffers(buffers)).collect();
        self.submit_each(&infos, doing)
    }

    /// Makes these submissions to the first queue, and waits for the last.
    pub(in super::super) fn submit_each(&self, infos: &[vk::SubmitInfo<'_>], doing: &str) -> Result<()> {
        self.submit_to(&infos.iter().map(|info| (0, *info)).collect::<Vec<_>>(), doing)
    }

    /// Waits for a submission that exceeded its limit: once for as long as one may take, then not again. An error where
    /// the device executes nothing, or is still not done.
    pub(in super::super) fn ready(&self, doing: &str) -> Result<()> {
        if self.0.given_up.get() {
            return Err(Error::device(doing, "the device does not execute what it is given"));
        }
        let patience = if self.0.waits_for_late.get() { self.0.patience.get() } else { Duration::ZERO };
        if !self.0.finished_within(patience) {
            self.0.waits_for_late.set(false);
            return Err(Error::device(doing, "the device is still busy with what it did not finish in time"));
        }
        Ok(())
    }

    /// Makes submissions to the queue of each number, and waits for the last.
    pub(in super::super) fn submit_to(&self, infos: &[(usize, vk::SubmitInfo<'_>)], doing: &str) -> Result<()> {
        let raw = &self.0.raw;
        let Some((last, others)) = infos.split_last() else { return Ok(()) };
        self.ready(doing)?;
        self.0.submissions.set(self.0.submissions.get() + infos.len() as u64);
        let submit = |(queue, info): &(usize, vk::SubmitInfo<'_>), fence: vk::Fence| {
            let queue = self.0.queues[*queue];
            // SAFETY: the command buffers are complete and of this device, and so is the fence.
            vk_call("vkQueueSubmit", doing, || unsafe { raw.queue_submit(queue, &[*info], fence) })
        };
        let fence = self.fence(doing)?;
        let submitted = others
            .iter()
            .try_for_each(|info| submit(info, vk::Fence::null()))
            .and_then(|()| submit(last, fence))
            // Those before the one that was refused may be running.
            .inspect_err(|_| {
                // SAFETY: the device is alive.
                let _ = unsafe { raw.device_wait_idle() };
            });
        let running = submitted.is_ok();
        let done = submitted.and_then(|()| self.wait(fence, doing));
        match running && done.is_err() {
            true => self.0.late.set(fence),
            false => self.keep_fence(fence),
        }
        done
    }

    /// Waits for a fence, as chosen, for as long as a submission may take.
    fn wait(&self, fence: vk::Fence, doing: &str) -> Result<()> {
        let (raw, begin) = (&self.0.raw, Instant::now());
        let awake = AWAKE.min(self.0.patience.get());
        while self.choices().waiting == Waiting::Poll && begin.elapsed() < awake {
            // SAFETY: the fence is alive.
            if vk_call("vkGetFenceStatus", doing, || unsafe { raw.get_fence_status(fence) })? {
                return Ok(());
            }
            std::hint::spin_loop();
        }
        let patience = nanoseconds(self.0.patience.get());
        // SAFETY: as above.
        vk_call("vkWaitForFences", doing, || unsafe { raw.wait_for_fences(&[fence], true, patience) })
    }

    /// Whether what the device used may be freed: nothing runs on it, and it has not been given up. After a wait that
    /// failed, a submission may still run: then this waits once more, for [`GRACE`], and what the submission uses is
    /// leaked if it takes longer.
    pub(in super::super) fn finished(&self) -> bool {
        self.0.finished()
    }

    /// Submits nothing more to this device, and leaks what was made on it.
    pub(in super::super) fn give_up(&self) {
        self.0.given_up.set(true);
    }

    /// A command buffer ready to record, for one submission.
    pub(in super::super) fn begin(&self, doing: &str) -> Result<vk::CommandBuffer> {
        self.begin_as(vk::CommandBufferLevel::PRIMARY, vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT, doing)
    }

    /// A command buffer of this level and use, ready to record.
    pub(in super::super) fn begin_as(
        &self,
        level: vk::CommandBufferLevel,
        usage: vk::CommandBufferUsageFlags,
        doing: &str,
    ) -> Result<vk::CommandBuffer> {
        let raw = &self.0.raw;
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(self.0.pool).level(level).command_buffer_count(1);
        let inheritance = vk::CommandBufferInheritanceInfo::default();
        let begin = vk::CommandBufferBeginInfo::default().flags(usage).inheritance_info(&inheritance);
        // SAFETY: the pool is this device's and used by one thread at a time.
        unsafe {
            let commands = vk_call("vkAllocateCommandBuffers", doing, || raw.allocate_command_buffers(&info))?[0];
            self.label(commands, doing);
            let begun = vk_call("vkBeginCommandBuffer", doing, || raw.begin_command_buffer(commands, &begin));
            begun.inspect_err(|_| self.discard(commands)).map(|()| commands)
        }
    }

    /// Frees a command buffer, unless it may still be running.
    pub(in super::super) fn discard(&self, commands: vk::CommandBuffer) {
        if self.finished() {
            // SAFETY: it is of this device's pool, and nothing is running.
            unsafe { self.0.raw.free_command_buffers(self.0.pool, &[commands]) };
        }
    }
}

/// A duration in nanoseconds, as Vulkan takes it.
fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Inner {
    /// See [`LogicalDevice::finished`].
    pub(super) fn finished(&self) -> bool {
        let finished = self.finished_within(self.grace.get());
        if !finished {
            self.grace.set(Duration::ZERO);
        }
        finished
    }

    /// Whether nothing runs on the device, after a wait of at most this long.
    fn finished_within(&self, limit: Duration) -> bool {
        if self.given_up.get() {
            return false;
        }
        let fence = self.late.get();
        if fence == vk::Fence::null() {
            return true;
        }
        // SAFETY: the fence is alive; it is destroyed once it is signalled or its device lost.
        unsafe {
            let wait = self.raw.wait_for_fences(&[fence], true, nanoseconds(limit));
            if wait == Err(vk::Result::TIMEOUT) {
                return false;
            }
            self.raw.destroy_fence(fence, None);
        }
        self.late.set(vk::Fence::null());
        self.grace.set(GRACE);
        self.waits_for_late.set(true);
        true
    }
}
