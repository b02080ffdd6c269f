//! What becomes of recorded command buffers: submitted, waited for, their timestamps read, and freed.

use ash::vk;

use super::Encoded;
use crate::error::Result;
use crate::gpu::call::vk_call;
use crate::gpu::list::{Entry, Timing};

impl Encoded {
    /// Submits it, waits for it, and returns the time of each part on the device.
    pub(in super::super) fn run(&self) -> Result<Vec<Timing>> {
        let (raw, limits) = (self.device.raw(), self.device.limits());
        let mut stages: Vec<String> = Vec::new();
        let mut dispatches = 0;
        for entry in &self.list {
            match entry {
                Entry::Begin(name, _) => stages.push(name.clone()),
                Entry::Dispatch(_) => dispatches += 1,
                Entry::Copy(_) | Entry::End => {}
            }
        }
        let names = stages.clone();
        stages.dedup();
        let doing = format!("running a frame ({}; {dispatches} dispatches)", stages.join(", "));
        for event in self.events.iter().filter(|event| **event != vk::Event::null()) {
            // SAFETY: the event is alive, and nothing is running that uses it.
            vk_call("vkResetEvent", &doing, || unsafe { raw.reset_event(*event) })?;
        }
        match &self.batches {
            Some(batches) => batches.submit(&self.primaries, &doing)?,
            None => self.device.submit_all(&self.primaries, &doing)?,
        }
        let mut ticks = vec![0u64; 2 * names.len().min(self.timed_parts)];
        if !ticks.is_empty() {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            vk_call("vkGetQueryPoolResults", &doing, || {
                // SAFETY: every query of the range was written by the submission.
                unsafe { raw.get_query_pool_results(self.queries.0, 0, &mut ticks, flags) }
            })?;
        }
        // Without the clocks its parts have times, but no moments.
        let now = if ticks.is_empty() { None } else { self.device.clocks(&doing).ok().flatten() };
        let began = |ticks: Option<&u64>| {
            let moment = now.as_ref()?;
            Some((moment.of(*ticks?, limits)?, moment.within))
        };
        let (period, mask) = (f64::from(limits.timestamp_period), limits.timestamp_mask);
        let between = |from: Option<&u64>, to: Option<&u64>| match (from, to) {
            (Some(from), Some(to)) => (to.wrapping_sub(*from) & mask) as f64 * period * 1e-6,
            _ => f64::NAN,
        };
        let timing = |(k, name): (usize, &String)| Timing {
            name: name.clone(),
            milliseconds: between(ticks.get(2 * k), ticks.get(2 * k + 1)),
            start: between(ticks.first(), ticks.get(2 * k)),
            began: began(ticks.get(2 * k)),
            dispatches: self.counts[k][0],
            barriers: self.counts[k][1],
        };
        Ok(names.iter().enumerate().map(timing).collect())
    }
}

impl Drop for Encoded {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        self.primaries.iter().chain(&self.secondaries).for_each(|commands| self.device.discard(*commands));
        if self.queries.1 > 0 {
            self.device.keep_queries(self.queries);
        }
        // SAFETY: a submitted frame has been waited for; one that was not submitted is not in use.
        unsafe {
            self.events.iter().for_each(|event| self.device.raw().destroy_event(*event, None));
        }
    }
}
