//! A compute kernel: a pipeline made from SPIR-V, and what it binds.

use std::time::{Duration, Instant};

use ash::vk;

use super::call::vk_call;
use super::count::{self, Tally};
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use super::reflect::{Access, Reflected, reflect};
use super::spirv_module::{round_to_nearest, without_rounding};
use crate::error::{Error, Result};
use crate::layout::GROUPS_A_ROW;

/// What identifies a kernel.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct KernelKey {
    /// Its name, `transport/blocks/gather`.
    pub name: String,
    /// Its specialization constants 0, 1, ...
    pub constants: Vec<u32>,
}

/// A pipeline and what it binds. Freed when dropped.
pub struct Kernel {
    pub(super) pipeline: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    pub(super) set_layout: vk::DescriptorSetLayout,
    /// Its name, `transport/blocks/gather`.
    pub name: String,
    /// The buffers it binds, by binding.
    pub accesses: Vec<Access>,
    /// Bytes of push constants it takes.
    pub push_bytes: u32,
    /// Invocations of a group.
    pub group: u32,
    /// How long the driver took to create the pipeline.
    pub creation: Duration,
    /// Its counters, if it counts what it does.
    pub(super) meter: Option<Meter>,
    pub(super) device: LogicalDevice,
}

/// The counters of a kernel.
pub(super) struct Meter {
    /// What each block that counts does when it runs once.
    blocks: Vec<count::Block>,
    /// How often each has run: two words a block, the lower one first.
    pub(super) counters: Buffer,
}

impl Kernel {
    /// The kernel with counters, if its SPIR-V is of the kind that the build makes; else without.
    pub(super) fn counting(device: &LogicalDevice, name: &str, words: Vec<u32>, constants: &[u32]) -> Result<Self> {
        let Some(counted) = count::counted(&words) else { return Self::new(device, name, words, constants) };
        let mut kernel = Self::new(device, name, counted.words, constants)?;
        let counters = Buffer::new(device, "counters", 8 * counted.blocks.len() as u64)?;
        counters.upload(&vec![0; 8 * counted.blocks.len()])?;
        kernel.meter = Some(Meter { blocks: counted.blocks, counters });
        Ok(kernel)
    }

    /// The groups of a dispatch of this many invocations: all in one row where they fit, else rows of equal length.
    pub(crate) fn grid(&self, invocations: u64) -> [u32; 3] {
        let groups = invocations.div_ceil(u64::from(self.group));
        let row = u64::from(GROUPS_A_ROW).min(self.device.limits().groups[0].into()).max(1);
        [groups.min(row), groups.div_ceil(row), 1].map(|count| u32::try_from(count).unwrap_or(u32::MAX))
    }

    /// What it has done since the last call, if it counts.
    pub(super) fn tally(&self) -> Result<Option<Tally>> {
        let Some(meter) = &self.meter else { return Ok(None) };
        let mut counts = vec![0u64; meter.blocks.len()];
        meter.counters.download(bytemuck::cast_slice_mut(&mut counts))?;
        meter.counters.upload(&vec![0; 8 * counts.len()])?;
        Ok(Some(Tally::new(&meter.blocks, &counts)))
    }

    /// The kernel of this SPIR-V with these specialization constants (0, 1, ...), or what the device lacks for it.
    pub(crate) fn new(device: &LogicalDevice, name: &str, words: Vec<u32>, constants: &[u32]) -> Result<Self> {
        let doing = format!("preparing kernel {name}");
        let found = reflect(name, &words)?;
        check(device, &found, constants, &doing)?;
        let words = as_given(device, words);

        let mut kernel = Self {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            name: name.to_string(),
            accesses: found.accesses,
            push_bytes: found.push_bytes,
            group: found.group,
            creation: Duration::ZERO,
            meter: None,
            device: device.clone(),
        };
        let bindings: Vec<_> = kernel
            .accesses
            .iter()
            .map(|access| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(access.binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let entries: Vec<_> = (0..constants.len())
            .map(|i| vk::SpecializationMapEntry { constant_id: i as u32, offset: 4 * i as u32, size: 4 })
            .collect();
        let special = vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(constants));
        let raw = device.raw();
        // SAFETY: every handle is this device's and is stored in `kernel` at once, which frees it after a failure.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            kernel.set_layout =
                vk_call("vkCreateDescriptorSetLayout", &doing, || raw.create_descriptor_set_layout(&info, None))?;
            let sets = [kernel.set_layout];
            let push = [vk::PushConstantRange {
                stage_flags: vk::ShaderStageFlags::COMPUTE,
                offset: 0,
                size: kernel.push_bytes,
            }];
            let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            if kernel.push_bytes > 0 {
                info = info.push_constant_ranges(&push);
            }
            kernel.layout = vk_call("vkCreatePipelineLayout", &doing, || raw.create_pipeline_layout(&info, None))?;
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            let module = vk_call("vkCreateShaderModule", &doing, || raw.create_shader_module(&info, None))?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main")
                .specialization_info(&special);
            let flags = match device.extras().statistics {
                true => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
                false => vk::PipelineCreateFlags::empty(),
            };
            let info = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(kernel.layout)];
            let begin = Instant::now();
            let made = vk_call("vkCreateComputePipelines", &doing, || {
                raw.create_compute_pipelines(device.pipeline_cache(), &info, None).map_err(|(_, code)| code)
            });
            kernel.creation = begin.elapsed();
            raw.destroy_shader_module(module, None);
            kernel.pipeline = made?[0];
        }
        device.label(kernel.pipeline, name);
        Ok(kernel)
    }
}

/// A module as the driver is given it: with a request to round to nearest, where the device takes one.
pub(super) fn as_given(device: &LogicalDevice, words: Vec<u32>) -> Vec<u32> {
    let words = without_rounding(&words);
    if device.limits().round_to_nearest { round_to_nearest(words) } else { words }
}

/// Fails where the device allows less than a kernel needs, or where the number of constants is not the kernel's.
fn check(device: &LogicalDevice, found: &Reflected, constants: &[u32], doing: &str) -> Result<()> {
    let limits = device.limits();
    let count = u32::try_from(found.accesses.len()).unwrap_or(u32::MAX);
    for (what, needed, allowed) in [
        ("storage buffers", count, limits.storage_buffers),
        ("bytes of push constants", found.push_bytes, limits.push_bytes),
        ("invocations in a group", found.group, limits.group_invocations),
    ] {
        if needed > allowed {
            return Err(Error::device(doing, format!("it needs {needed} {what}, the device allows {allowed}")));
        }
    }
    if found.constants != constants.len() {
        let (has, given) = (found.constants, constants.len());
        return Err(Error::device(doing, format!("it has {has} specialization constants, {given} were given")));
    }
    Ok(())
}

impl Drop for Kernel {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        let raw = self.device.raw();
        // SAFETY: every submission is waited for, so the device no longer uses them; null handles are allowed.
        unsafe {
            raw.destroy_pipeline(self.pipeline, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
