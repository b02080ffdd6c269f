//! Named buffers.

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};

use super::device::Device;
use super::faults::tried;
use super::transfer::{download, upload};
use crate::error::{Error, Result};

/// A storage buffer on the device. Freed when dropped.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    name: String,
    size: u64,
    allocation: Option<Allocation>,
    device: Device,
}

impl Buffer {
    /// Allocates `size` bytes of device memory under this name (at least 4 bytes, so that an empty list can be bound).
    pub fn new(device: &Device, name: &str, size: u64) -> Result<Self> {
        Self::at(device, name, size, MemoryLocation::GpuOnly)
    }

    /// The same in memory of another kind.
    pub(super) fn at(device: &Device, name: &str, size: u64, location: MemoryLocation) -> Result<Self> {
        let doing = format!("allocating {size} bytes for buffer {name}");
        let size = size.max(4);
        let limit = device.limits().allocation_bytes;
        if size > limit {
            return Err(Error::device(doing, format!("the device allows {limit} bytes in one allocation")));
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        let raw = tried("vkCreateBuffer", &doing, || {
            // SAFETY: the device is alive.
            unsafe { device.0.raw.create_buffer(&info, None) }
        })?;
        let mut buffer = Self { raw, name: name.to_string(), size, allocation: None, device: device.clone() };
        device.label(raw, name);
        // SAFETY: the buffer was just created.
        let requirements = unsafe { device.0.raw.get_buffer_memory_requirements(raw) };
        let description = AllocationCreateDesc {
            name,
            requirements,
            location,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = {
            let mut held =
                device.0.allocator.lock().map_err(|_| Error::device(doing.as_str(), "the allocator broke"))?;
            let allocator = held.as_mut().ok_or_else(|| Error::device(doing.as_str(), "the device is closing"))?;
            let allocate = || allocator.allocate(&description).map_err(|error| code_of(&error));
            tried("vkAllocateMemory", &doing, allocate)?
        };
        let bound = tried("vkBindBufferMemory", &doing, || {
            // SAFETY: memory and offset come from the allocator for just these requirements.
            unsafe { device.0.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
        });
        let (now, most) = device.memory();
        let now = now + allocation.size();
        device.0.allocated.set((now, most.max(now)));
        buffer.allocation = Some(allocation);
        bound.map(|()| buffer)
    }

    /// Its size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Copies `bytes` to the start of the buffer.
    pub fn upload(&self, bytes: &[u8]) -> Result<()> {
        upload(&self.device, &[(self, 0, bytes)])
    }

    /// Copies the start of the buffer to `bytes`.
    pub fn download(&self, bytes: &mut [u8]) -> Result<()> {
        let ranges = [(self, 0, bytes.len() as u64)];
        download(&self.device, &ranges, |_, at, part| bytes[at..at + part.len()].copy_from_slice(part))
    }

    /// The bytes, where the host can see them.
    pub(super) fn mapped(&mut self, doing: &str) -> Result<&mut [u8]> {
        self.allocation
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .ok_or_else(|| Error::device(doing, "the device offers no memory that the host can see"))
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

impl Drop for Buffer {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        // SAFETY: every submission is waited for, so the device no longer uses the buffer.
        unsafe { self.device.0.raw.destroy_buffer(self.raw, None) };
        if let (Some(allocation), Ok(mut allocator)) = (self.allocation.take(), self.device.0.allocator.lock())
            && let Some(allocator) = allocator.as_mut()
        {
            let (now, most) = self.device.memory();
            self.device.0.allocated.set((now.saturating_sub(allocation.size()), most));
            let _ = allocator.free(allocation);
        }
    }
}
