//! A frame over two queues: which step goes to which queue, and what it waits for on the other one.

use std::cell::Cell;
use std::collections::BTreeMap;

use ash::vk;
use ash::vk::Handle as _;

use crate::error::Result;
use crate::gpu::call::vk_call;
use crate::gpu::choices::Barriers;
use crate::gpu::list::{Entry, Listed};
use crate::gpu::logical_device::LogicalDevice;
use crate::gpu::order::{Wait, uses, waits};

/// The command buffers of a frame on two queues. Each signals a number on its queue's timeline: how many have run
/// there.
pub(super) struct Batches {
    device: LogicalDevice,
    batches: Vec<Batch>,
    timelines: [vk::Semaphore; 2],
    /// What the timelines have reached.
    reached: Cell<[u64; 2]>,
}

/// A command buffer: a step, or what is listed before or after steps.
#[derive(Clone, Debug, Default, PartialEq)]
struct Batch {
    queue: usize,
    /// How many batches of the other queue it waits for.
    after: u64,
    /// How many dispatches it has.
    dispatches: usize,
}

/// How many batches of each queue have read and written a buffer, counted to the last that did.
#[derive(Clone, Copy, Default)]
struct Known {
    read: [u64; 2],
    written: [u64; 2],
}

/// One use of a buffer: its handle, and whether it is read and written.
type Use = (u64, bool, bool);

impl Batches {
    /// Gives each step of a list a queue.
    pub(super) fn new(device: &LogicalDevice, list: &[Entry]) -> Result<Self> {
        let mut batches = Self {
            device: device.clone(),
            batches: placed(&steps(list)),
            timelines: Default::default(),
            reached: Cell::default(),
        };
        for timeline in &mut batches.timelines {
            let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
            let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
            // SAFETY: the device is alive; the semaphores are freed with `batches`.
            *timeline = vk_call("vkCreateSemaphore", "recording a frame", || unsafe {
                device.raw().create_semaphore(&info, None)
            })?;
            device.label(*timeline, "batches that are done");
        }
        Ok(batches)
    }

    /// What each dispatch waits for on its own queue.
    pub(super) fn waits(&self, dispatches: &[&Listed], barriers: Barriers) -> Vec<Option<Wait>> {
        let queue_of: Vec<usize> = self.batches.iter().flat_map(|batch| vec![batch.queue; batch.dispatches]).collect();
        let mut found = vec![None; dispatches.len()];
        for queue in 0..2 {
            let on_queue: Vec<usize> = (0..dispatches.len()).filter(|at| queue_of[*at] == queue).collect();
            let list = on_queue.iter().map(|at| uses(dispatches[*at]));
            for (at, wait) in on_queue.iter().zip(waits(list, barriers)) {
                found[*at] = wait.map(|wait| Wait { after: on_queue[wait.after], ..wait });
            }
        }
        found
    }

    /// Submits these command buffers, one a batch, and waits for both queues.
    pub(super) fn submit(&self, commands: &[vk::CommandBuffer], doing: &str) -> Result<()> {
        let base = self.reached.get();
        let mut done = base;
        let mut numbers = Vec::new();
        for batch in &self.batches {
            done[batch.queue] += 1;
            numbers.push(([base[1 - batch.queue] + batch.after], [done[batch.queue]]));
        }
        let stages = [vk::PipelineStageFlags::ALL_COMMANDS; 2];
        let mut timed: Vec<_> = numbers
            .iter()
            .map(|(wait, signal)| {
                let info = vk::TimelineSemaphoreSubmitInfo::default();
                info.wait_semaphore_values(wait).signal_semaphore_values(signal)
            })
            .collect();
        let mut last = vk::TimelineSemaphoreSubmitInfo::default().wait_semaphore_values(&done);
        let mut infos: Vec<(usize, vk::SubmitInfo<'_>)> = self
            .batches
            .iter()
            .zip(commands.chunks(1))
            .zip(&mut timed)
            .map(|((batch, commands), timed)| {
                let [own, other] = [batch.queue, 1 - batch.queue].map(|queue| &self.timelines[queue..=queue]);
                let info = vk::SubmitInfo::default()
                    .command_buffers(commands)
                    .wait_semaphores(other)
                    .wait_dst_stage_mask(&stages[..1])
                    .signal_semaphores(own);
                (batch.queue, info.push_next(timed))
            })
            .collect();
        // The fence of the last submission has to mean that both queues are done.
        let both = vk::SubmitInfo::default().wait_semaphores(&self.timelines).wait_dst_stage_mask(&stages);
        infos.push((0, both.push_next(&mut last)));
        self.device.submit_to(&infos, doing)?;
        self.reached.set(done);
        Ok(())
    }
}

impl Drop for Batches {
    fn drop(&mut self) {
        if self.device.finished() {
            // SAFETY: nothing is running that waits for them; null handles are allowed.
            self.timelines.iter().for_each(|timeline| unsafe { self.device.raw().destroy_semaphore(*timeline, None) });
        }
    }
}

/// The dispatches of each command buffer by what they use: a new one begins after a step, if another step follows.
fn steps(list: &[Entry]) -> Vec<Vec<Vec<Use>>> {
    let last = list.iter().rposition(|entry| matches!(entry, Entry::Begin(..))).unwrap_or(0);
    let (mut all, mut open) = (vec![Vec::new()], 0);
    for (at, entry) in list.iter().enumerate() {
        match entry {
            Entry::Begin(..) => open += 1,
            Entry::End => {
                open -= 1;
                if open == 0 && at < last {
                    all.push(Vec::new());
                }
            }
            Entry::Copy(_) => {}
            Entry::Dispatch(listed) => {
                let listed_uses =
                    uses(listed).map(|(buffer, reads, writes)| (buffer.as_raw(), reads, writes)).collect();
                all.last_mut().unwrap_or(&mut Vec::new()).push(listed_uses);
            }
        }
    }
    all
}

/// A queue for each step: that of the last one that it depends on, or the one with less to do.
fn placed(steps: &[Vec<Vec<Use>>]) -> Vec<Batch> {
    let mut known: BTreeMap<u64, Known> = BTreeMap::new();
    let (mut counts, mut loads) = ([0u64; 2], [0; 2]);
    let mut found = Vec::with_capacity(steps.len());
    for step in steps {
        let mut needed = [0u64; 2];
        for (buffer, _, writes) in step.iter().flatten() {
            let Some(known) = known.get(buffer) else { continue };
            for (queue, needed) in needed.iter_mut().enumerate() {
                let read = if *writes { known.read[queue] } else { 0 };
                *needed = (*needed).max(known.written[queue]).max(read);
            }
        }
        let follows = [0, 1].map(|queue| counts[queue] > 0 && needed[queue] == counts[queue]);
        let queue = match follows {
            [true, false] => 0,
            [false, true] => 1,
            _ => usize::from(loads[1] < loads[0]),
        };
        counts[queue] += 1;
        loads[queue] += step.len();
        for (buffer, reads, writes) in step.iter().flatten() {
            let entry = known.entry(*buffer).or_default();
            if *reads {
                entry.read[queue] = counts[queue];
            }
            if *writes {
                entry.written[queue] = counts[queue];
            }
        }
        found.push(Batch { queue, after: needed[1 - queue], dispatches: step.len() });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn independent_steps_part_and_meet() {
        let (reads, writes) = (|buffer| (buffer, true, false), |buffer| (buffer, false, true));
        // 0 writes a; 1 writes b; 2 reads a, writes c; 3 reads b; 4 reads c and b, writes a.
        let steps = [
            vec![vec![writes(1)]],
            vec![vec![writes(2)]],
            vec![vec![reads(1), writes(3)]],
            vec![vec![reads(2)]],
            vec![vec![reads(3), reads(2)], vec![writes(1)]],
        ];
        let found = placed(&steps);
        assert_eq!(found.iter().map(|batch| batch.queue).collect::<Vec<_>>(), [0, 1, 0, 1, 0]);
        // Only the last one needs the other queue: for b, which was written there first.
        assert_eq!(found.iter().map(|batch| batch.after).collect::<Vec<_>>(), [0, 0, 0, 0, 1]);
        assert_eq!(found[4].dispatches, 2);
        // What was read on the other queue may be overwritten only after that.
        let found = placed(&[
            vec![vec![writes(1)]],
            vec![vec![writes(2)]],
            vec![vec![reads(1), writes(2)]],
            vec![vec![writes(1)]],
        ]);
        for (at, batch) in found.iter().enumerate() {
            let other = found[..at].iter().filter(|earlier| earlier.queue != batch.queue).count() as u64;
            assert!(batch.after <= other, "{found:?}");
        }
        let [third, fourth] = [&found[2], &found[3]];
        assert!(third.queue == fourth.queue || fourth.after > 0, "{found:?}");
    }
}
