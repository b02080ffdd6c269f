//! A single kernel run outside of any frame, from SPIR-V that is no stage's: for facts about a driver, and for the cost
//! of a formula.

use std::rc::Rc;

use super::bind::Binding;
use super::count::Tally;
use super::device::Device;
use super::kernel::Kernel;
use super::list::Timing;
use super::memory::Buffer;
use super::record::{Recorder, Work};
use crate::error::{Error, Result};

/// A kernel that belongs to no stage.
pub struct SingleKernel<'a> {
    /// Its name in messages.
    pub name: &'a str,
    /// Its SPIR-V, whole words in the byte order of the host.
    pub spirv: &'a [u8],
    /// Its specialization constants 0, 1, ...
    pub constants: &'a [u32],
}

impl SingleKernel<'_> {
    /// Runs it `times` times for `count` invocations each, in one submission, with buffer k at binding k.
    ///
    /// The buffers are copied to the device before the first run and back after the last. Returns the time of every
    /// run; the first one includes what the driver does when a pipeline is first used.
    pub fn run(&self, device: &Device, buffers: &mut [Vec<u8>], count: u64, times: usize) -> Result<Vec<Timing>> {
        let kernel = Rc::new(Kernel::new(device, self.name, self.words()?, self.constants)?);
        self.run_kernel(device, &kernel, buffers, count, times)
    }

    /// Runs it once with counters, and returns what it has done; none where its SPIR-V is not of the kind that the
    /// build makes.
    pub fn tally(&self, device: &Device, buffers: &mut [Vec<u8>], count: u64) -> Result<Option<Tally>> {
        let kernel = Rc::new(Kernel::counting(device, self.name, self.words()?, self.constants)?);
        self.run_kernel(device, &kernel, buffers, count, 1)?;
        Ok(kernel.tallies()?.pop().map(|(_, tally)| tally))
    }

    fn words(&self) -> Result<Vec<u32>> {
        let doing = || format!("running kernel {} alone", self.name);
        if !self.spirv.len().is_multiple_of(4) {
            return Err(Error::device(doing(), format!("{} bytes are no whole words", self.spirv.len())));
        }
        Ok(self.spirv.chunks_exact(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    fn run_kernel(
        &self,
        device: &Device,
        kernel: &Rc<Kernel>,
        buffers: &mut [Vec<u8>],
        count: u64,
        times: usize,
    ) -> Result<Vec<Timing>> {
        let mut held = Vec::with_capacity(buffers.len());
        for (number, bytes) in buffers.iter().enumerate() {
            let buffer = Buffer::new(device, &format!("{} {number}", self.name), bytes.len() as u64)?;
            buffer.upload(bytes)?;
            held.push(buffer);
        }
        let binding = |(number, buffer)| Binding { number, buffer, offset: 0, size: Buffer::size(buffer) };
        let bindings: Vec<_> = (0..).zip(&held).map(binding).collect();
        let mut recorder = Recorder::new(device, times)?;
        for _ in 0..times {
            recorder.part(self.name, |recorder| recorder.dispatch(kernel, &bindings, &[], Work::Invocations(count)))?;
        }
        let timings = recorder.submit()?;
        for (buffer, bytes) in held.iter().zip(buffers) {
            buffer.download(bytes)?;
        }
        Ok(timings)
    }
}
