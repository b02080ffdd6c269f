//! The counters of a kernel: a range of one buffer for each of its dispatches.

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Kernel, Shape};
use crate::error::Result;
use crate::gpu::count::{Block, Counted, Tally, counted};
use crate::gpu::logical_device::LogicalDevice;
use crate::gpu::memory::Buffer;
use crate::gpu::reflect::{has_subgroups, reflect};

/// Most dispatches that have counters of their own; those beyond share the last one's, and the longest of them counts
/// for each.
const MOST: usize = 256;
/// Every device binds buffers from multiples of so many bytes.
const ALIGNMENT: usize = 256;

/// The number of the next dispatch of any kernel that counts.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// The counters of a kernel.
pub(in super::super) struct Meter {
    /// What each block does when it runs once.
    blocks: Vec<Block>,
    /// A range for each dispatch.
    counters: Buffer,
    /// The dispatches since the last reading: their numbers, and the parts of the work that were timed with them.
    dispatches: RefCell<Vec<(u64, String)>>,
    /// How many dispatches share the last range with its own.
    beyond: Cell<u64>,
}

impl Meter {
    fn new(device: &LogicalDevice, blocks: Vec<Block>) -> Result<Self> {
        let bytes = MOST * Self::stride(&blocks);
        let counters = Buffer::new(device, "counters", bytes as u64)?;
        counters.upload(&vec![0; bytes])?;
        Ok(Self { blocks, counters, dispatches: RefCell::default(), beyond: Cell::new(0) })
    }

    /// Bytes from one range to the next.
    fn stride(blocks: &[Block]) -> usize {
        (4 * Counted::counters(blocks)).next_multiple_of(ALIGNMENT)
    }

    /// The buffer, and the first byte and the size of the range of the next dispatch, which is timed as this part.
    pub(in super::super) fn next(&self, part: &str) -> (&Buffer, u64, u64) {
        let mut dispatches = self.dispatches.borrow_mut();
        if dispatches.len() < MOST {
            dispatches.push((NEXT.fetch_add(1, Ordering::Relaxed), part.to_string()));
        } else {
            self.beyond.set(self.beyond.get() + 1);
        }
        let stride = Self::stride(&self.blocks) as u64;
        (&self.counters, (dispatches.len() as u64 - 1) * stride, stride)
    }

    /// What each dispatch has done since the last call, after its number and its part.
    fn read(&self) -> Result<Vec<((u64, String), Tally)>> {
        let dispatches = self.dispatches.take();
        let stride = Self::stride(&self.blocks) / 4;
        let mut words = vec![0u32; dispatches.len() * stride];
        if words.is_empty() {
            return Ok(Vec::new());
        }
        self.counters.download(bytemuck::cast_slice_mut(&mut words))?;
        self.counters.upload(&vec![0; 4 * words.len()])?;
        let tally = |words: &[u32]| Tally::new(&self.blocks, words);
        let mut tallies: Vec<((u64, String), Tally)> =
            dispatches.into_iter().zip(words.chunks(stride).map(tally)).collect();
        if let Some((_, last)) = tallies.last_mut() {
            last.repeat(self.beyond.take());
        }
        Ok(tallies)
    }
}

impl Kernel {
    /// The kernel with counters, if its SPIR-V is of the kind that the build makes; else without.
    pub(in super::super) fn counting(
        device: &LogicalDevice,
        name: &str,
        words: Vec<u32>,
        constants: &[u32],
    ) -> Result<Self> {
        let Some(counted) = counted(&words) else { return Self::new(device, name, words, constants) };
        // What counts elects one of a subgroup, whichever are there: it asks for no more than the kernel does.
        let (shape, shuffles) = (Shape::of(device, name, &*reflect(name, &words)?), has_subgroups(&words));
        let mut kernel = Self::shaped(device, name, counted.words, constants, (shape, shuffles))?;
        kernel.meter = Some(Meter::new(device, counted.blocks)?);
        Ok(kernel)
    }

    /// What each dispatch has done since the last call, after its number among all dispatches that count, and the part
    /// of the work that was timed with it; none if it does not count.
    pub(in super::super) fn tallies(&self) -> Result<Vec<((u64, String), Tally)>> {
        self.meter.as_ref().map_or(Ok(Vec::new()), Meter::read)
    }
}
