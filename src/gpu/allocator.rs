//! The memory of a device: what is allocated, and how much at once.

use std::cell::Cell;
use std::sync::Mutex;

use ash::vk;
use gpu_allocator::AllocationError;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, Allocator, AllocatorCreateDesc};

use super::call::vk_call;
use crate::error::{Error, Result};

/// Bytes of device memory, staging buffers included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Bytes allocated now.
    pub allocated: u64,
    /// The most bytes allocated at once since [`super::LogicalDevice::forget_peak`].
    pub peak: u64,
}

/// The allocator of a device, and what it has allocated.
#[derive(Default)]
pub(super) struct Memory {
    /// `None` before the device is open and once it is being destroyed.
    allocator: Mutex<Option<Allocator>>,
    used: Cell<MemoryUse>,
}

impl Memory {
    pub(super) fn new(description: &AllocatorCreateDesc, doing: &str) -> Result<Self> {
        let allocator = Allocator::new(description).map_err(|error| Error::device(doing, error))?;
        Ok(Self { allocator: Mutex::new(Some(allocator)), used: Cell::default() })
    }

    pub(super) fn used(&self) -> MemoryUse {
        self.used.get()
    }

    pub(super) fn forget_peak(&self) {
        let allocated = self.used().allocated;
        self.used.set(MemoryUse { allocated, peak: allocated });
    }

    /// The names of all allocations.
    pub(super) fn names(&self) -> Vec<String> {
        let Ok(allocator) = self.allocator.lock() else { return Vec::new() };
        let report = allocator.as_ref().map(Allocator::generate_report);
        report
            .map(|report| report.allocations.into_iter().map(|allocation| allocation.name).collect())
            .unwrap_or_default()
    }

    pub(super) fn allocate(&self, description: &AllocationCreateDesc<'_>, doing: &str) -> Result<Allocation> {
        let mut held = self.allocator.lock().map_err(|_| Error::device(doing, "the allocator broke"))?;
        let allocator = held.as_mut().ok_or_else(|| Error::device(doing, "the device is closing"))?;
        let allocate = || allocator.allocate(description).map_err(|error| code_of(&error));
        let allocation = vk_call("vkAllocateMemory", doing, allocate)?;
        let MemoryUse { allocated, peak } = self.used();
        let allocated = allocated + allocation.size();
        self.used.set(MemoryUse { allocated, peak: peak.max(allocated) });
        Ok(allocation)
    }

    /// Frees memory that nothing uses any more.
    pub(super) fn free(&self, allocation: Allocation) {
        if let Ok(mut allocator) = self.allocator.lock()
            && let Some(allocator) = allocator.as_mut()
        {
            let MemoryUse { allocated, peak } = self.used();
            self.used.set(MemoryUse { allocated: allocated.saturating_sub(allocation.size()), peak });
            let _ = allocator.free(allocation);
        }
    }

    /// The allocator, for whoever destroys the device; nothing can be allocated after that.
    pub(super) fn take(&self) -> Option<Allocator> {
        self.allocator.lock().ok().and_then(|mut allocator| allocator.take())
    }
}

/// The allocator's error as the result code behind it.
fn code_of(error: &AllocationError) -> vk::Result {
    match error {
        AllocationError::OutOfMemory => vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
        AllocationError::FailedToMap(_) => vk::Result::ERROR_MEMORY_MAP_FAILED,
        _ => vk::Result::ERROR_UNKNOWN,
    }
}
