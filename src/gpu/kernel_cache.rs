//! The kernels made for a device so far, and the ways in which they differ from those of the build.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::kernel::{Kernel, KernelKey, words_for};
use super::logical_device::LogicalDevice;
use crate::error::Result;

/// Kernels by name and specialization constants. Drivers take up to a tenth of a second to compile a pipeline, so all
/// users of a device share them, but for kernels that count: each user counts for itself.
#[derive(Default)]
pub(super) struct KernelCache {
    /// SPIR-V that replaces the build's, by kernel.
    replaced: BTreeMap<String, Vec<u32>>,
    /// Whether kernels count what they do.
    counts: bool,
    /// Those made so far that do not count.
    made: RefCell<BTreeMap<KernelKey, Rc<Kernel>>>,
}

impl KernelCache {
    /// An empty cache that differs from this one in a kernel.
    pub(super) fn replacing(&self, kernel: &str, words: Vec<u32>) -> Self {
        let mut replaced = self.replaced.clone();
        replaced.insert(kernel.to_string(), words);
        Self { replaced, counts: self.counts, made: RefCell::default() }
    }

    /// An empty cache of the same kernels.
    pub(super) fn forgetting(&self) -> Self {
        Self { replaced: self.replaced.clone(), counts: self.counts, made: RefCell::default() }
    }

    /// An empty cache whose kernels count what they do.
    pub(super) fn counting(&self) -> Self {
        Self { counts: true, ..self.forgetting() }
    }

    /// The kernels that do not come from the build.
    pub(super) fn replaced(&self) -> impl Iterator<Item = &str> {
        self.replaced.keys().map(String::as_str)
    }

    /// The SPIR-V of a kernel for this device: what replaces the build's, or the build's.
    pub(super) fn words(&self, device: &LogicalDevice, name: &str) -> Result<Vec<u32>> {
        if let Some(words) = self.replaced.get(name) {
            return Ok(words.clone());
        }
        words_for(device, name)
    }

    /// The kernel of this key for this device, made if need be.
    pub(super) fn get(&self, device: &LogicalDevice, key: &KernelKey) -> Result<Rc<Kernel>> {
        if let Some(kernel) = self.made.borrow().get(key) {
            return Ok(kernel.clone());
        }
        let KernelKey { name, constants } = key;
        let words = self.words(device, name)?;
        if self.counts {
            return Ok(Rc::new(Kernel::counting(device, name, words, constants)?));
        }
        let kernel = Rc::new(Kernel::new(device, name, words, constants)?);
        self.made.borrow_mut().insert(key.clone(), kernel.clone());
        Ok(kernel)
    }
}
