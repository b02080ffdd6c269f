//! Whether a device executes what it is given. Null hardware and no-op drivers report every submission as done and
//! leave memory as it was. A small kernel writes a function of a number over poison, and the host compares.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use gpu_allocator::MemoryLocation;

use super::bind::Binding;
use super::device::Device;
use super::kernel::{Kernel, KernelKey};
use super::memory::Buffer;
use super::record::{Recorder, Work};
use crate::error::{Error, Result};

/// The name of the kernel.
pub const EXECUTES: &str = "measure/executes";
/// Words of its buffer: the number, and what the kernel writes.
const WORDS: usize = 16;
/// What the host writes there before the kernel runs.
const POISON: u32 = 0xffc0_dead;

/// A dispatch at the end of a submission, by which the host knows that the device executed it.
pub struct ExecutionCheck {
    kernel: Rc<Kernel>,
    words: RefCell<Buffer>,
    /// The number of the submission, which no other has.
    number: Cell<u32>,
}

impl ExecutionCheck {
    /// A check for submissions to this device.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = device.kernel(&KernelKey { name: EXECUTES.into(), constants: Vec::new() })?;
        let words = Buffer::in_memory(device, "executed", 4 * WORDS as u64, MemoryLocation::GpuToCpu)?;
        // Buffers may hold what an earlier process left: its numbers must not be right here.
        let seed = std::time::UNIX_EPOCH.elapsed().map_or(0, |time| time.subsec_nanos());
        Ok(Self { kernel, words: RefCell::new(words), number: Cell::new(seed ^ std::process::id()) })
    }

    /// Lists the dispatch, as the last one before the submission, and writes the number and poison for it to see.
    pub fn list(&self, recorder: &mut Recorder) -> Result<()> {
        let number = self.number.get().wrapping_add(1);
        self.number.set(number);
        let mut given = [POISON; WORDS];
        given[0] = number;
        let mut words = self.words.borrow_mut();
        words.mapped("checking that the device executes")?[..4 * WORDS].copy_from_slice(bytemuck::cast_slice(&given));
        let binding = Binding { number: 0, buffer: &words, offset: 0, size: words.size() };
        recorder.dispatch(&self.kernel, &[binding], &[], Work::Grid([1, 1, 1]))
    }

    /// An error if the submission that it was listed for is done and the dispatch was not executed. From then on
    /// nothing of the device is destroyed: drivers of null hardware crash there.
    pub fn verify(&self, doing: &str) -> Result<()> {
        let mut words = self.words.borrow_mut();
        let found: Vec<u32> = bytemuck::pod_collect_to_vec(&words.mapped(doing)?[..4 * WORDS]);
        let number = self.number.get();
        let right = |(place, word): (usize, &u32)| *word == (number ^ place as u32).wrapping_mul(2_654_435_761);
        if found[0] == number && found.iter().enumerate().skip(1).all(right) {
            return Ok(());
        }
        words.device.give_up();
        let what = format!(
            "{} reports work as done that it did not execute: it is null hardware, or its driver is broken; use another \
             device, or --device cpu",
            words.device.name()
        );
        Err(Error::device(doing, what))
    }
}

/// Fails if the device, which was just opened, does not execute a dispatch.
pub(super) fn verify_execution(device: &Device) -> Result<()> {
    let check = ExecutionCheck::new(device)?;
    let mut recorder = Recorder::new(device, 0)?;
    check.list(&mut recorder)?;
    recorder.submit()?;
    check.verify(&format!("opening {}", device.name()))
}
