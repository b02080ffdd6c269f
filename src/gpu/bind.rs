//! Descriptor sets: which range of which buffer is bound to each binding of a kernel.

use std::collections::BTreeMap;

use ash::vk;
use ash::vk::Handle as _;

use super::call::vk_call;
use super::kernel::Kernel;
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use crate::error::{Error, Result};

/// How many descriptor sets a pool holds.
const SETS: u32 = 256;

/// A range of a buffer, and the binding number that it is bound to.
#[derive(Clone, Copy)]
pub struct Binding<'a> {
    /// The binding number.
    pub number: u32,
    /// The buffer.
    pub buffer: &'a Buffer,
    /// First byte bound.
    pub offset: u64,
    /// Number of bytes bound.
    pub size: u64,
}

/// What identifies a descriptor set.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct SetKey {
    pipeline: u64,
    /// By binding.
    ranges: Vec<BoundRange>,
}

/// A range of a buffer, the buffer by its handle.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct BoundRange {
    buffer: u64,
    offset: u64,
    size: u64,
}

/// The descriptor sets of one recording. Freed when dropped.
pub(super) struct Sets {
    device: LogicalDevice,
    pools: Vec<vk::DescriptorPool>,
    /// How many sets the last pool has left.
    left: u32,
    made: BTreeMap<SetKey, vk::DescriptorSet>,
}

impl Sets {
    pub(super) fn new(device: &LogicalDevice) -> Self {
        Self { device: device.clone(), pools: Vec::new(), left: 0, made: BTreeMap::new() }
    }

    /// The descriptor set of this kernel with these buffers, created when it is first needed.
    pub(super) fn get(&mut self, kernel: &Kernel, bindings: &[Binding<'_>]) -> Result<vk::DescriptorSet> {
        let doing = format!("binding the buffers of kernel {}", kernel.name);
        let mut infos = Vec::with_capacity(kernel.accesses.len());
        let mut ranges = Vec::with_capacity(kernel.accesses.len());
        for access in &kernel.accesses {
            let binding = bindings
                .iter()
                .find(|b| b.number == access.binding)
                .ok_or_else(|| Error::device(doing.as_str(), format!("nothing is bound at {}", access.binding)))?;
            let Binding { buffer, offset, size, .. } = *binding;
            ranges.push(BoundRange { buffer: buffer.raw.as_raw(), offset, size });
            infos.push([vk::DescriptorBufferInfo { buffer: buffer.raw, offset, range: size.max(4) }]);
        }
        let key = SetKey { pipeline: kernel.pipeline.as_raw(), ranges };
        if let Some(set) = self.made.get(&key) {
            return Ok(*set);
        }
        let raw = self.device.raw();
        // SAFETY: pools and sets are this device's and live as long as the recorder.
        let set = unsafe {
            if self.left == 0 {
                let sizes = [vk::DescriptorPoolSize {
                    ty: vk::DescriptorType::STORAGE_BUFFER,
                    descriptor_count: SETS * self.device.limits().storage_buffers.min(32),
                }];
                let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS).pool_sizes(&sizes);
                self.pools.push(vk_call("vkCreateDescriptorPool", &doing, || raw.create_descriptor_pool(&info, None))?);
                self.left = SETS;
            }
            let layouts = [kernel.set_layout];
            let pool = self.pools.last().copied().unwrap_or_default();
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let set = vk_call("vkAllocateDescriptorSets", &doing, || raw.allocate_descriptor_sets(&info))?[0];
            let writes: Vec<_> = kernel
                .accesses
                .iter()
                .zip(&infos)
                .map(|(access, info)| {
                    vk::WriteDescriptorSet::default()
                        .dst_set(set)
                        .dst_binding(access.binding)
                        .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                        .buffer_info(info)
                })
                .collect();
            raw.update_descriptor_sets(&writes, &[]);
            set
        };
        self.left -= 1;
        self.made.insert(key, set);
        Ok(set)
    }
}

impl Drop for Sets {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        for pool in &self.pools {
            // SAFETY: the recording has been waited for, or was never submitted.
            unsafe { self.device.raw().destroy_descriptor_pool(*pool, None) };
        }
    }
}
