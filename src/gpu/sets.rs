//! Descriptor sets of a recording: which range of which buffer each kernel finds at its bindings, and the uniform
//! buffer of its constants.

use std::collections::BTreeMap;

use ash::vk;
use ash::vk::Handle as _;
use gpu_allocator::MemoryLocation;

use super::call::vk_call;
use super::choices::{Constants, Descriptors};
use super::list::{BoundRange, Listed};
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use super::pushed::UNIFORM_SET;
use crate::error::Result;
use crate::layout::BUFFER_IDS;

/// How many descriptor sets a pool holds.
const SETS: u32 = 256;
const COMPUTE: vk::PipelineBindPoint = vk::PipelineBindPoint::COMPUTE;

/// The descriptor sets of one recording. Freed when dropped.
pub(super) struct Sets {
    device: LogicalDevice,
    pools: Vec<vk::DescriptorPool>,
    /// How many sets the last pool has left.
    left: u32,
    /// The set of each dispatch; none where there are no sets.
    of_dispatch: Vec<vk::DescriptorSet>,
    uniforms: Option<Uniforms>,
}

/// A uniform buffer that holds what would be push constants.
struct Uniforms {
    set: vk::DescriptorSet,
    /// The first byte of each dispatch's constants.
    offsets: Vec<u32>,
    _buffer: Buffer,
}

/// What identifies a descriptor set: a pipeline, and ranges by binding.
type SetKey<'a> = (u64, &'a [BoundRange]);

impl Sets {
    pub(super) fn new(device: &LogicalDevice) -> Self {
        Self { device: device.clone(), pools: Vec::new(), left: 0, of_dispatch: Vec::new(), uniforms: None }
    }

    /// Makes the sets of these dispatches.
    pub(super) fn prepare(&mut self, dispatches: &[&Listed]) -> Result<()> {
        match self.device.choices().descriptors {
            Descriptors::Shared => {
                let mut made: BTreeMap<SetKey<'_>, vk::DescriptorSet> = BTreeMap::new();
                for listed in dispatches {
                    let key = (listed.kernel.pipeline.as_raw(), listed.ranges.as_slice());
                    let set = match made.get(&key) {
                        Some(known) => *known,
                        None => self.make_for(listed)?,
                    };
                    made.insert(key, set);
                    self.of_dispatch.push(set);
                }
            }
            Descriptors::Dispatch => {
                for listed in dispatches {
                    let set = self.make_for(listed)?;
                    self.of_dispatch.push(set);
                }
            }
            Descriptors::Frame => self.prepare_frame(dispatches)?,
            Descriptors::Push => {}
        }
        if self.device.choices().constants == Constants::Uniform {
            self.prepare_uniforms(dispatches)?;
        }
        Ok(())
    }

    /// One set for dispatches in a row that agree on the range at each binding.
    fn prepare_frame(&mut self, dispatches: &[&Listed]) -> Result<()> {
        let mut first = 0;
        while let Some(listed) = dispatches.get(first) {
            let mut agreed: BTreeMap<u32, BoundRange> = BTreeMap::new();
            let agrees = |agreed: &BTreeMap<u32, BoundRange>, listed: &Listed| {
                bindings(listed).iter().all(|(number, range)| agreed.get(number).is_none_or(|known| known == range))
            };
            let count = dispatches[first..]
                .iter()
                .take_while(|next| {
                    let fits = agrees(&agreed, next);
                    agreed.extend(bindings(next).into_iter().filter(|_| fits));
                    fits
                })
                .count();
            let all: Vec<_> = agreed.into_iter().collect();
            let set = self.make(listed.kernel.set_layout, &all, "buffers of a frame")?;
            self.of_dispatch.extend(vec![set; count]);
            first += count;
        }
        Ok(())
    }

    /// Writes the constants of all dispatches to a buffer.
    fn prepare_uniforms(&mut self, dispatches: &[&Listed]) -> Result<()> {
        let Some(most) = dispatches.iter().map(|listed| listed.push.len()).max().filter(|most| *most > 0) else {
            return Ok(());
        };
        let doing = "filling the constants of a frame";
        let align = usize::try_from(self.device.limits().uniform_alignment.max(16)).unwrap_or(256);
        let (mut bytes, mut offsets) = (Vec::new(), Vec::new());
        for listed in dispatches {
            offsets.push(bytes.len() as u32);
            bytes.extend(&listed.push);
            bytes.resize(bytes.len().next_multiple_of(align), 0);
        }
        // The range that is bound ends within the buffer at each offset.
        bytes.resize(bytes.len() + most, 0);
        let mut buffer = Buffer::in_memory(&self.device, "constants", bytes.len() as u64, MemoryLocation::CpuToGpu)?;
        buffer.mapped(doing)?[..bytes.len()].copy_from_slice(&bytes);
        let layout = dispatches.iter().map(|listed| listed.kernel.uniform_layout);
        let layout = layout.into_iter().find(|layout| *layout != vk::DescriptorSetLayout::null()).unwrap_or_default();
        let set = self.allocate(layout, "constants of a frame")?;
        let info = [vk::DescriptorBufferInfo { buffer: buffer.raw, offset: 0, range: most as u64 }];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(set)
            .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC)
            .buffer_info(&info);
        // SAFETY: set and buffer are alive, and nothing is running that uses them.
        unsafe { self.device.raw().update_descriptor_sets(&[write], &[]) };
        self.uniforms = Some(Uniforms { set, offsets, _buffer: buffer });
        Ok(())
    }

    /// A set for this dispatch.
    fn make_for(&mut self, listed: &Listed) -> Result<vk::DescriptorSet> {
        self.make(listed.kernel.set_layout, &bindings(listed), &listed.kernel.name)
    }

    /// A set of this layout with these ranges, by binding.
    fn make(
        &mut self,
        layout: vk::DescriptorSetLayout,
        ranges: &[(u32, BoundRange)],
        name: &str,
    ) -> Result<vk::DescriptorSet> {
        let set = self.allocate(layout, name)?;
        let infos = infos(ranges);
        let writes = writes(ranges, &infos, set);
        // SAFETY: set and buffers are alive, and nothing is running that uses the set.
        unsafe { self.device.raw().update_descriptor_sets(&writes, &[]) };
        Ok(set)
    }

    /// A new set of this layout.
    fn allocate(&mut self, layout: vk::DescriptorSetLayout, name: &str) -> Result<vk::DescriptorSet> {
        let doing = "binding the buffers of a frame";
        let (raw, choices) = (self.device.raw(), self.device.choices());
        if self.left == 0
            && let Some(spare) = self.device.spare_sets()
        {
            self.pools.push(spare);
            self.left = SETS;
        }
        // SAFETY: pools and sets are this device's and live as long as the recording.
        unsafe {
            if self.left == 0 {
                let (buffers, flags) = match choices.descriptors {
                    Descriptors::Frame => {
                        (BUFFER_IDS.len() as u32 + 1, vk::DescriptorPoolCreateFlags::UPDATE_AFTER_BIND)
                    }
                    _ => (self.device.limits().storage_buffers.min(32), vk::DescriptorPoolCreateFlags::empty()),
                };
                let sizes = [
                    vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: SETS * buffers },
                    vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, descriptor_count: 1 },
                ];
                let used = if choices.constants == Constants::Uniform { 2 } else { 1 };
                let info =
                    vk::DescriptorPoolCreateInfo::default().flags(flags).max_sets(SETS).pool_sizes(&sizes[..used]);
                self.pools.push(vk_call("vkCreateDescriptorPool", doing, || raw.create_descriptor_pool(&info, None))?);
                self.device.label(self.pools[self.pools.len() - 1], "sets of a frame");
                self.left = SETS;
            }
            let layouts = [layout];
            let pool = self.pools.last().copied().unwrap_or_default();
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let set = vk_call("vkAllocateDescriptorSets", doing, || raw.allocate_descriptor_sets(&info))?[0];
            self.device.label(set, name);
            self.left -= 1;
            Ok(set)
        }
    }

    /// Records the bindings and push constants of the dispatch of this index.
    ///
    /// # Safety
    /// The command buffer has to be recording, and the dispatch to be one of those that were prepared.
    pub(super) unsafe fn bind(&self, commands: vk::CommandBuffer, listed: &Listed, index: usize) {
        let (raw, kernel) = (self.device.raw(), &listed.kernel);
        // SAFETY: the caller's.
        unsafe {
            match self.of_dispatch.get(index) {
                Some(set) => raw.cmd_bind_descriptor_sets(commands, COMPUTE, kernel.layout, 0, &[*set], &[]),
                None => {
                    let ranges = bindings(listed);
                    let infos = infos(&ranges);
                    let writes = writes(&ranges, &infos, vk::DescriptorSet::null());
                    let functions = self.device.push_descriptors();
                    functions.cmd_push_descriptor_set(commands, COMPUTE, kernel.layout, 0, &writes);
                }
            }
            if listed.push.is_empty() {
                return;
            }
            match &self.uniforms {
                Some(Uniforms { set, offsets, .. }) => raw.cmd_bind_descriptor_sets(
                    commands,
                    COMPUTE,
                    kernel.layout,
                    UNIFORM_SET,
                    &[*set],
                    &[offsets[index]],
                ),
                None => {
                    let stage = vk::ShaderStageFlags::COMPUTE;
                    raw.cmd_push_constants(commands, kernel.layout, stage, 0, &listed.push);
                }
            }
        }
    }
}

/// The range at each binding of a dispatch.
fn bindings(listed: &Listed) -> Vec<(u32, BoundRange)> {
    listed.kernel.accesses.iter().map(|access| access.binding).zip(listed.ranges.iter().copied()).collect()
}

fn infos(ranges: &[(u32, BoundRange)]) -> Vec<[vk::DescriptorBufferInfo; 1]> {
    let info = |(_, range): &(u32, BoundRange)| {
        [vk::DescriptorBufferInfo { buffer: range.buffer, offset: range.offset, range: range.size.max(4) }]
    };
    ranges.iter().map(info).collect()
}

fn writes<'a>(
    ranges: &[(u32, BoundRange)],
    infos: &'a [[vk::DescriptorBufferInfo; 1]],
    set: vk::DescriptorSet,
) -> Vec<vk::WriteDescriptorSet<'a>> {
    let write = |((number, _), info): (&(u32, BoundRange), &'a [vk::DescriptorBufferInfo; 1])| {
        vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(*number)
            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
            .buffer_info(info)
    };
    ranges.iter().zip(infos).map(write).collect()
}

impl Drop for Sets {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        // The recording has been waited for, or was never submitted.
        self.pools.iter().for_each(|pool| self.device.keep_sets(*pool));
    }
}
