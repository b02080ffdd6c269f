//! Named buffers on a device, and their memory.

use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::call::vk_call;
use super::choices::MemoryKind;
use super::logical_device::LogicalDevice;
use crate::error::{Error, Result};

/// Buffers of at most this many bytes lie where host and device both reach them, so that no submission has to copy
/// what changes from frame to frame or what a frame tells the host.
const SMALL: u64 = 64 << 10;
/// Most bytes that the host reads in place where its caches do not hold them.
const READ_IN_PLACE: u64 = 4 << 10;

/// The number of the next buffer.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// A storage buffer on the device. Freed when dropped.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    /// A number that no other buffer has or had.
    pub(super) number: u64,
    name: String,
    size: u64,
    allocation: Option<Allocation>,
    pub(super) device: LogicalDevice,
}

impl Buffer {
    /// Allocates `size` bytes of device memory under this name (at least 4 bytes, so that an empty list can be bound).
    pub fn new(device: &LogicalDevice, name: &str, size: u64) -> Result<Self> {
        let location = match device.choices().memory {
            MemoryKind::Local if size <= SMALL && device.adapter().offers.local_visible => MemoryLocation::CpuToGpu,
            MemoryKind::Local | MemoryKind::Dedicated => MemoryLocation::GpuOnly,
            MemoryKind::Visible => MemoryLocation::CpuToGpu,
            MemoryKind::Cached => MemoryLocation::GpuToCpu,
        };
        Self::in_memory(device, name, size, location)
    }

    /// The same in memory of another kind.
    pub(super) fn in_memory(device: &LogicalDevice, name: &str, size: u64, location: MemoryLocation) -> Result<Self> {
        let doing = format!("allocating {size} bytes for buffer {name}");
        let size = size.max(4);
        let limit = device.limits().allocation_bytes;
        if size > limit {
            return Err(Error::device(doing, format!("the device allows {limit} bytes in one allocation")));
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        let raw = vk_call("vkCreateBuffer", &doing, || {
            // SAFETY: the device is alive.
            unsafe { device.raw().create_buffer(&info, None) }
        })?;
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let mut buffer = Self { raw, number, name: name.to_string(), size, allocation: None, device: device.clone() };
        device.label(raw, name);
        // SAFETY: the buffer was just created.
        let requirements = unsafe { device.raw().get_buffer_memory_requirements(raw) };
        let description = AllocationCreateDesc {
            name,
            requirements,
            location,
            linear: true,
            allocation_scheme: match device.choices().memory {
                // Staging buffers have no allocation of their own.
                MemoryKind::Dedicated if location == MemoryLocation::GpuOnly => AllocationScheme::DedicatedBuffer(raw),
                _ => AllocationScheme::GpuAllocatorManaged,
            },
        };
        let allocation = buffer.allocation.insert(device.heap().allocate(&description, &doing)?);
        vk_call("vkBindBufferMemory", &doing, || {
            // SAFETY: memory and offset come from the allocator for exactly these requirements.
            unsafe { device.raw().bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
        })?;
        Ok(buffer)
    }

    /// Its size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the host finds the bytes of a small buffer; none where they have to be copied. No submission may be
    /// running.
    pub(super) fn in_place(&self, reads: bool) -> Option<NonNull<u8>> {
        use vk::MemoryPropertyFlags as Flags;
        let allocation = self.allocation.as_ref().filter(|_| self.size <= SMALL)?;
        let kind = allocation.memory_properties();
        let quick = !reads || self.size <= READ_IN_PLACE || kind.contains(Flags::HOST_CACHED);
        let seen = kind.contains(Flags::HOST_VISIBLE | Flags::HOST_COHERENT);
        allocation.mapped_ptr().map(NonNull::cast).filter(|_| seen && quick)
    }

    /// The bytes, where the host can see them.
    pub(super) fn mapped(&mut self, doing: &str) -> Result<&mut [u8]> {
        self.allocation
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .ok_or_else(|| Error::device(doing, "the device offers no memory that the host can see"))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        // SAFETY: every submission is waited for, so the device no longer uses the buffer.
        unsafe { self.device.raw().destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            self.device.heap().free(allocation);
        }
    }
}
