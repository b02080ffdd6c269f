//! A frame as a list: its parts, and the dispatches of each. What becomes of the list is [`super::encode`]'s business.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use super::bind::Binding;
use super::choices::{Constants, Queues, Submissions};
use super::count;
use super::encode::{Encoded, Paces};
use super::first_use;
use super::kernel::Kernel;
use super::list::{BoundRange, Entry, Groups, Listed, Place, Timing};
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use super::transfer::BufferRange;
use crate::error::{Error, Result};
use crate::layout::GROUP_SIZE;

/// How large a dispatch is.
#[derive(Clone, Copy)]
pub enum Work<'a> {
    /// This many invocations, rounded up to whole groups.
    Invocations(u64),
    /// This many groups in each dimension.
    Grid([u32; 3]),
    /// As many groups as three numbers in a buffer say: an indirect dispatch.
    Groups {
        /// The buffer.
        buffer: &'a Buffer,
        /// The first byte of the three numbers.
        offset: u64,
    },
}

/// A frame being listed.
pub struct Recorder {
    device: LogicalDevice,
    list: Vec<Entry>,
    /// How many parts are timed.
    timed_parts: usize,
    /// How many parts have the name of each kernel and a number.
    numbered: BTreeMap<String, u32>,
}

impl Recorder {
    /// Begins a frame whose first `parts` labelled parts are timed.
    pub fn new(device: &LogicalDevice, parts: usize) -> Result<Self> {
        let timed_parts = if device.limits().timestamp_period > 0.0 { parts } else { 0 };
        Ok(Self { device: device.clone(), list: Vec::new(), timed_parts, numbered: BTreeMap::new() })
    }

    /// Lists what `body` lists as a part of this name: within a debug label, and with a timestamp before and after.
    pub fn part(&mut self, name: &str, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.part_of(name, Place::default(), body)
    }

    /// The same for this part of the work.
    pub fn part_of(&mut self, name: &str, of: Place, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.list.push(Entry::Begin(name.to_string(), of));
        let done = body(self);
        self.list.push(Entry::End);
        done
    }

    /// The name of the part that was begun last.
    fn latest_part(&self) -> &str {
        let begun = self.list.iter().rev().find_map(|entry| match entry {
            Entry::Begin(name, _) => Some(name.as_str()),
            _ => None,
        });
        begun.unwrap_or_default()
    }

    /// A name for the next dispatch of this kernel: with its number among them.
    pub fn numbered(&mut self, kernel: &str) -> String {
        let number = self.numbered.entry(kernel.to_string()).or_default();
        *number += 1;
        format!("{kernel} #{number}")
    }

    /// Lists a dispatch of a kernel; it waits for earlier dispatches that it depends on.
    pub fn dispatch(
        &mut self,
        kernel: &Rc<Kernel>,
        bindings: &[Binding<'_>],
        push: &[u8],
        work: Work<'_>,
    ) -> Result<()> {
        let doing = || format!("recording kernel {}", kernel.name);
        if matches!(work, Work::Invocations(0)) || matches!(work, Work::Grid(groups) if groups.contains(&0)) {
            return Ok(());
        }
        let (given, takes) = (push.len(), kernel.push_bytes as usize);
        let Some(push) = push.get(..takes).filter(|_| given == takes || !kernel.built) else {
            return Err(Error::device(doing(), format!("{given} bytes of push constants given, it takes {takes}")));
        };
        let limit = self.device.limits().binding_bytes;
        for binding in bindings {
            if binding.size > limit {
                let (name, size) = (binding.buffer.name(), binding.size);
                return Err(Error::device(
                    doing(),
                    format!(
                        "buffer {name} has {size} bytes, the device binds at most {limit}; use fewer triangles or pixels, or \
                         --device cpu"
                    ),
                ));
            }
        }
        let groups = match work {
            Work::Invocations(count) => Groups::Direct(kernel.grid(count)),
            Work::Grid(groups) => Groups::Direct(groups),
            Work::Groups { .. }
                if !kernel.shape.counted && kernel.shape.group.is_some_and(|size| size != GROUP_SIZE) =>
            {
                return Err(Error::device(doing(), "its groups are counted by another kernel, in groups of 64"));
            }
            Work::Groups { buffer, offset } => Groups::Counted { range: range(buffer, offset, 12) },
        };
        let most = self.device.limits().groups;
        if let Groups::Direct(direct) = groups
            && (direct[0] > most[0] || direct[1] > most[1])
        {
            let what = format!(
                "it takes {} x {} groups, the device dispatches at most {} x {}",
                direct[0], direct[1], most[0], most[1]
            );
            return Err(Error::device(doing(), what));
        }
        // A kernel that counts has a range of its own buffer for each dispatch.
        let counters = kernel.meter.as_ref().map(|meter| meter.next(self.latest_part()));
        let mut ranges = Vec::with_capacity(kernel.accesses.len());
        for access in &kernel.accesses {
            let bound = bindings.iter().find(|b| b.number == access.binding);
            ranges.push(match (bound, counters) {
                (Some(bound), _) => self.bound(bound),
                (None, Some((buffer, first, size))) if access.binding == count::BINDING => range(buffer, first, size),
                (None, _) => {
                    return Err(Error::device(doing(), format!("nothing is bound at {}", access.binding)));
                }
            });
        }
        let baked = self.device.choices().constants == Constants::Specialization && !push.is_empty();
        let (kernel, push) = match baked {
            true => (kernel.baked(push)?, Vec::new()),
            false => (kernel.clone(), push.to_vec()),
        };
        self.list.push(Entry::Dispatch(Listed { kernel, ranges, push, groups }));
        Ok(())
    }

    /// The range that a dispatch binds. What has no bytes makes no barrier: each dispatch has a word of its own there,
    /// in case it writes one.
    fn bound(&self, binding: &Binding<'_>) -> BoundRange {
        let own = ((self.list.len() as u64) << 8) % binding.buffer.size().max(1);
        range(binding.buffer, if binding.size == 0 { own } else { binding.offset }, binding.size)
    }

    /// Lists a copy of all bytes of a range to the beginning of a buffer, or with `back` from there; it waits for all
    /// before it, and all after it wait for it.
    pub fn copy(&mut self, from: BufferRange<'_>, to: &Buffer, back: bool) {
        let mut ranges = [range(from.buffer, from.offset, from.size), range(to, 0, from.size)];
        if back {
            ranges.reverse();
        }
        self.list.push(Entry::Copy(ranges));
    }

    /// Submits the frame, waits for it, and returns the time of each part on the device.
    pub fn submit(self) -> Result<Vec<Timing>> {
        first_use::compile(&self.device, &self.list);
        Encoded::new(&self.device, self.list, self.timed_parts, Vec::new())?.run()
    }

    /// Whether a frame that takes long is cut into several submissions.
    fn cuts(&self) -> bool {
        let choices = self.device.choices();
        let whole = matches!(choices.submissions, Submissions::Reused | Submissions::Frame);
        whole && choices.queues == Queues::One && self.device.shows().is_some()
    }

    /// The same, by the kept recording of an equal frame, if there is one; in several submissions if that takes long.
    pub fn submit_again(self, kept: &Recordings) -> Result<Vec<Timing>> {
        let (device, paces, cut) = (self.device.clone(), &kept.paces, self.cuts());
        let limit = device.longest();
        let cuts = |list: &[Entry]| if cut { paces.cuts(list, limit) } else { Vec::new() };
        if device.choices().submissions != Submissions::Reused {
            first_use::compile(&device, &self.list);
            let cuts = cuts(&self.list);
            let encoded = Encoded::new(&device, self.list, self.timed_parts, cuts)?;
            let times = encoded.run()?;
            if cut {
                encoded.tell(paces, &times);
            }
            return Ok(times);
        }
        let mut kept = kept.kept.borrow_mut();
        let known = kept.iter().position(|recording| recording.is_of(&self.list, self.timed_parts));
        let new = known.is_none();
        let at = match known {
            // The recording that was used last is the last to be forgotten.
            Some(at) => {
                kept[at..].rotate_left(1);
                kept.len() - 1
            }
            None => {
                if kept.len() == MOST_KEPT {
                    kept.remove(0);
                }
                first_use::compile(&device, &self.list);
                let cuts = cuts(&self.list);
                kept.push(Encoded::new(&device, self.list, self.timed_parts, cuts)?);
                kept.len() - 1
            }
        };
        let done = kept[at].run();
        match &done {
            Err(_) => kept.clear(),
            // A frame that has not run before tells how long its steps take, and so does one that takes long.
            Ok(times) if cut && (new || total(times) > limit) => {
                kept[at].tell(paces, times);
                if !kept[at].is_cut_as(paces, limit) {
                    kept.remove(at);
                }
            }
            Ok(_) => {}
        }
        done
    }
}

/// How many recordings are kept: more than most frames have submissions. Steps of a solver are one each.
const MOST_KEPT: usize = 128;

/// Recordings of frames that may come again.
#[derive(Default)]
pub struct Recordings {
    kept: RefCell<Vec<Encoded>>,
    /// How long their steps took.
    paces: Paces,
}

impl Recordings {
    /// Forgets all recordings, since buffers that they bind are gone.
    pub fn clear(&self) {
        self.kept.borrow_mut().clear();
    }
}

/// How long the steps of a frame took together.
fn total(times: &[Timing]) -> Duration {
    Duration::from_secs_f64(times.iter().map(|time| time.milliseconds.max(0.0)).sum::<f64>() * 1e-3)
}

fn range(buffer: &Buffer, offset: u64, size: u64) -> BoundRange {
    BoundRange { buffer: buffer.raw, number: buffer.number, offset, size }
}
