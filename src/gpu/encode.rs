//! A listed frame as command buffers: which commands there are, and how they are submitted, is [`super::Choices`]'
//! business.

use std::time::Duration;

use ash::vk;

use super::call::vk_call;
use super::choices::{Barriers, Queues, Submissions, Timed};
use super::faults::{Told, drops, tell};
use super::list::{Entry, Groups, Listed, Place, Timing};
use super::logical_device::LogicalDevice;
use super::order::{Wait, uses, waits};
use super::sets::Sets;
use crate::error::Result;
use barriers::STAGES;
use batches::Batches;
pub(super) use cuts::Paces;

mod barriers;
mod batches;
mod cuts;
mod labels;
mod run;

/// A frame in command buffers. What it uses lives as long as it does; buffers are the caller's.
pub(super) struct Encoded {
    device: LogicalDevice,
    list: Vec<Entry>,
    timed_parts: usize,
    /// The entries before which another submission begins.
    cuts: Vec<usize>,
    /// The dispatches of each part, and the waits before them.
    counts: Vec<[usize; 2]>,
    /// In the order of submission.
    primaries: Vec<vk::CommandBuffer>,
    secondaries: Vec<vk::CommandBuffer>,
    sets: Sets,
    /// The event that follows a dispatch, by its index.
    events: Vec<vk::Event>,
    /// Where each command buffer is submitted, if not one after the other to one queue.
    batches: Option<Batches>,
    /// Timestamps of the parts: a pool, and how many queries it has.
    queries: (vk::QueryPool, u32),
    /// The command buffer being recorded.
    now: vk::CommandBuffer,
}

impl Encoded {
    /// Records a list, with timestamps around its first `timed_parts` parts, cut into submissions before these entries.
    pub(super) fn new(device: &LogicalDevice, list: Vec<Entry>, timed_parts: usize, cuts: Vec<usize>) -> Result<Self> {
        let doing = "recording a frame";
        let mut encoded = Self {
            device: device.clone(),
            list,
            timed_parts,
            cuts,
            counts: Vec::new(),
            primaries: Vec::new(),
            secondaries: Vec::new(),
            sets: Sets::new(device),
            events: Vec::new(),
            batches: None,
            queries: Default::default(),
            now: vk::CommandBuffer::null(),
        };
        encoded.begin(vk::CommandBufferLevel::PRIMARY)?;
        if timed_parts > 0 {
            let count = u32::try_from(2 * timed_parts).unwrap_or(u32::MAX);
            encoded.queries = device.queries(count, doing)?;
            if device.choices().queues == Queues::One {
                // SAFETY: the command buffer is recording; the pool has as many queries.
                unsafe { device.raw().cmd_reset_query_pool(encoded.now, encoded.queries.0, 0, count) };
            }
        }
        let list = std::mem::take(&mut encoded.list);
        let done = encoded.record(&list);
        encoded.list = list;
        done.map(|()| encoded)
    }

    /// Notes these times of its parts.
    pub(super) fn tell(&self, paces: &Paces, times: &[Timing]) {
        paces.note(&self.list, times);
    }

    /// Whether these times of its steps ask for the submissions that it has.
    pub(super) fn is_cut_as(&self, paces: &Paces, limit: Duration) -> bool {
        self.cuts == paces.cuts(&self.list, limit)
    }

    /// Whether it is the recording of this list.
    pub(super) fn is_of(&self, list: &[Entry], timed_parts: usize) -> bool {
        self.timed_parts == timed_parts && self.list == list
    }

    /// Begins another command buffer.
    fn begin(&mut self, level: vk::CommandBufferLevel) -> Result<()> {
        let usage = match self.device.choices().submissions {
            Submissions::Reused => vk::CommandBufferUsageFlags::empty(),
            _ => vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT,
        };
        self.now = self.device.begin_as(level, usage, "recording a frame")?;
        let all = if level == vk::CommandBufferLevel::PRIMARY { &mut self.primaries } else { &mut self.secondaries };
        all.push(self.now);
        Ok(())
    }

    /// Ends the command buffer being recorded.
    fn end(&self) -> Result<()> {
        tell(|| Told::Close);
        vk_call("vkEndCommandBuffer", "recording a frame", || {
            // SAFETY: the command buffer is complete; what it uses is owned by `self` or borrowed by the caller.
            unsafe { self.device.raw().end_command_buffer(self.now) }
        })
    }

    fn record(&mut self, list: &[Entry]) -> Result<()> {
        let device = self.device.clone();
        let choices = device.choices();
        let dispatches: Vec<&Listed> = list
            .iter()
            .filter_map(|entry| match entry {
                Entry::Dispatch(listed) => Some(listed),
                Entry::Begin(..) | Entry::Copy(_) | Entry::End => None,
            })
            .collect();
        self.sets.prepare(&dispatches)?;
        let waits = self.find_waits(list, &dispatches)?;
        self.make_events(&waits, dispatches.len())?;
        let apart = choices.submissions == Submissions::Step || choices.queues != Queues::One;
        let parts = list.iter().filter(|entry| matches!(entry, Entry::Begin(..))).count();
        let (mut part, mut index) = (0, 0);
        let mut open: Vec<(usize, &str, Place)> = Vec::new();
        for (at, entry) in list.iter().enumerate() {
            if self.cuts.binary_search(&at).is_ok() {
                self.cut(&open)?;
            }
            match entry {
                Entry::Begin(name, place) => {
                    if choices.submissions == Submissions::Secondary && open.is_empty() {
                        self.begin(vk::CommandBufferLevel::SECONDARY)?;
                    }
                    if choices.queues != Queues::One && open.is_empty() {
                        self.reset_queries(part, 1 + inner_parts(&list[at + 1..]));
                    }
                    self.begin_part(name, *place, part);
                    open.push((part, name, *place));
                    self.counts.push([0; 2]);
                    part += 1;
                }
                Entry::End => {
                    let ended = open.pop();
                    self.end_part(ended.map_or(usize::MAX, |(part, ..)| part));
                    if open.is_empty() {
                        self.end_step(apart && part < parts)?;
                    }
                }
                Entry::Copy(ranges) => self.copy(ranges),
                Entry::Dispatch(listed) => {
                    if let Some(wait) = &waits[index] {
                        self.wait(wait);
                    }
                    if let Some((part, ..)) = open.last() {
                        self.counts[*part][0] += 1;
                        self.counts[*part][1] += usize::from(waits[index].is_some());
                    }
                    self.begin_label(&listed.kernel.name, open.last().map_or(Place::default(), |(.., place)| *place));
                    self.dispatch(listed, index);
                    self.end_label();
                    index += 1;
                }
            }
        }
        self.make_visible();
        self.end()
    }

    /// Goes on in another command buffer, within the same labels.
    fn cut(&mut self, open: &[(usize, &str, Place)]) -> Result<()> {
        // Barriers order what is submitted to one queue, wherever the command buffers end. Labels may go on in the next
        // one, too, but Mesa 22.3 crashes then.
        open.iter().for_each(|_| self.end_label());
        self.end()?;
        self.begin(vk::CommandBufferLevel::PRIMARY)?;
        open.iter().for_each(|(_, name, place)| self.begin_label(name, *place));
        Ok(())
    }

    /// Ends a step's command buffer, where it has one of its own; `apart` if another step's follows.
    fn end_step(&mut self, apart: bool) -> Result<()> {
        match self.device.choices().submissions {
            _ if apart => {
                // It may be the last one of its queue.
                self.make_visible();
                self.end()?;
                self.begin(vk::CommandBufferLevel::PRIMARY)
            }
            Submissions::Secondary => self.execute(),
            Submissions::Frame | Submissions::Step | Submissions::Reused => Ok(()),
        }
    }

    /// What each dispatch waits for within its queue; also finds the batches where there are several queues.
    fn find_waits(&mut self, list: &[Entry], dispatches: &[&Listed]) -> Result<Vec<Option<Wait>>> {
        let choices = self.device.choices();
        // A dispatch that is timed has the device to itself.
        let barriers = match choices.barriers {
            Barriers::Elided if choices.timed != Timed::Steps => Barriers::Every,
            barriers => barriers,
        };
        Ok(match choices.queues {
            Queues::One => waits(dispatches.iter().map(|listed| uses(listed)), barriers),
            Queues::Apart | Queues::Two => {
                let batches = Batches::new(&self.device, list)?;
                let waits = batches.waits(dispatches, barriers);
                self.batches = Some(batches);
                waits
            }
        })
    }

    /// Ends a secondary command buffer, and has the primary one execute it.
    fn execute(&mut self) -> Result<()> {
        self.end()?;
        let secondary = [self.now];
        self.now = self.primaries.last().copied().unwrap_or_default();
        // SAFETY: the primary command buffer is recording; the secondary one is complete.
        unsafe { self.device.raw().cmd_execute_commands(self.now, &secondary) };
        Ok(())
    }

    /// Records that these parts have no timestamps yet; with several queues each step does this for its parts.
    fn reset_queries(&self, part: usize, count: usize) {
        let end = (part + count).min(self.timed_parts);
        if part < end {
            let [first, count] = [2 * part, 2 * (end - part)].map(|number| number as u32);
            // SAFETY: the command buffer is recording; the queries lie within the pool.
            unsafe { self.device.raw().cmd_reset_query_pool(self.now, self.queries.0, first, count) };
        }
    }

    fn begin_part(&self, name: &str, place: Place, part: usize) {
        self.begin_label(name, place);
        // SAFETY: the command buffer is recording; the query lies within the pool.
        unsafe { self.timestamp(part, 0) };
    }

    fn end_part(&self, part: usize) {
        // SAFETY: as above.
        unsafe { self.timestamp(part, 1) };
        self.end_label();
    }

    /// SAFETY: the command buffer has to be recording.
    unsafe fn timestamp(&self, part: usize, end: u32) {
        if part < self.timed_parts {
            let stage = vk::PipelineStageFlags::COMPUTE_SHADER;
            // SAFETY: the caller's; the query lies within the pool.
            unsafe { self.device.raw().cmd_write_timestamp(self.now, stage, self.queries.0, 2 * part as u32 + end) };
        }
    }

    fn dispatch(&mut self, listed: &Listed, index: usize) {
        let (raw, kernel) = (self.device.raw(), &listed.kernel);
        tell(|| Told::Dispatch(kernel.name.clone()));
        if drops(&kernel.name) {
            return;
        }
        // SAFETY: kernel, set and buffers live until the submission has been waited for.
        unsafe {
            raw.cmd_bind_pipeline(self.now, vk::PipelineBindPoint::COMPUTE, kernel.pipeline);
            self.sets.bind(self.now, listed, index);
            match listed.groups {
                Groups::Direct([x, y, z]) => raw.cmd_dispatch(self.now, x, y, z),
                Groups::Counted { range } => raw.cmd_dispatch_indirect(self.now, range.buffer, range.offset),
            }
            if let Some(event) = self.events.get(index).filter(|event| **event != vk::Event::null()) {
                raw.cmd_set_event(self.now, *event, STAGES);
            }
        }
    }
}

/// The number of parts that begin before the open one ends.
fn inner_parts(list: &[Entry]) -> usize {
    let (mut open, mut count) = (1, 0);
    for entry in list {
        match entry {
            Entry::Begin(..) => (open, count) = (open + 1, count + 1),
            Entry::End => open -= 1,
            Entry::Dispatch(_) | Entry::Copy(_) => {}
        }
        if open == 0 {
            break;
        }
    }
    count
}
