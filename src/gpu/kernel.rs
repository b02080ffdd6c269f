//! Compute kernels: pipelines made when first used, from the SPIR-V of the build.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use ash::vk;

use super::count::{self, Tally};
use super::device::{Device, Inner};
use super::faults::tried;
use super::memory::Buffer;
use super::reflect::{Access, reflect, words_of};
use super::spirv_module::round_to_nearest;
use crate::error::{Error, Result};

/// A kernel's name and its specialization constants.
pub(super) type Key = (String, Vec<u32>);

/// A pipeline and what it binds. Freed when dropped.
pub struct Kernel {
    pub(super) pipeline: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    pub(super) set_layout: vk::DescriptorSetLayout,
    /// Its name, `transport/gather`.
    pub name: String,
    /// The buffers it binds, by binding.
    pub accesses: Vec<Access>,
    /// Bytes of push constants it takes.
    pub push_bytes: u32,
    /// Invocations of a group.
    pub group: u32,
    /// Where it counts how often each of its blocks runs, and what they do, if it counts.
    pub(super) meter: Option<Meter>,
    // Not a `Device`, which may hold this kernel.
    device: Rc<Inner>,
}

/// The counters of a kernel: two words a block, the lower first.
pub(super) struct Meter {
    blocks: Vec<count::Block>,
    pub(super) counters: Buffer,
}

/// The kernels that one twin of a state has asked for. Twins on one device share pipelines, which drivers take up to a
/// tenth of a second to compile; only kernels that count are each twin's own.
pub struct Kernels {
    device: Device,
    made: RefCell<BTreeMap<Key, Rc<Kernel>>>,
}

impl Kernels {
    /// An empty collection for this device.
    pub fn new(device: &Device) -> Self {
        Self { device: device.clone(), made: RefCell::default() }
    }

    /// The kernel of this name with these specialization constants (0, 1, ...), made if need be.
    pub fn get(&self, name: &str, constants: &[u32]) -> Result<Rc<Kernel>> {
        let key = (name.to_string(), constants.to_vec());
        if let Some(kernel) = self.made.borrow().get(&key) {
            return Ok(kernel.clone());
        }
        let kit = &self.device.1;
        let words = || kit.replaced.get(name).map_or_else(|| words_of(name), |words| Ok(words.clone()));
        let shared = kit.made.borrow().get(&key).cloned();
        let kernel = if let Some(kernel) = shared {
            kernel
        } else if kit.counts {
            Rc::new(Kernel::metered(&self.device, name, words()?, constants)?)
        } else {
            let kernel = Rc::new(Kernel::new(&self.device, name, words()?, constants)?);
            kit.made.borrow_mut().insert(key.clone(), kernel.clone());
            kernel
        };
        self.made.borrow_mut().insert(key, kernel.clone());
        Ok(kernel)
    }

    /// The kernels made so far, each with its specialization constants.
    pub fn made(&self) -> Vec<(String, Vec<u32>)> {
        self.made.borrow().keys().cloned().collect()
    }

    /// What each kernel has done since the last call, where kernels count; none have otherwise.
    pub fn tallies(&self) -> Result<Vec<(String, Tally)>> {
        let made = self.made.borrow();
        let mut tallies = Vec::new();
        for ((name, _), kernel) in made.iter() {
            tallies.extend(kernel.tally()?.map(|tally| (name.clone(), tally)));
        }
        Ok(tallies)
    }
}

impl Kernel {
    /// The kernel with counters, if its SPIR-V is of the kind that the build makes.
    pub(super) fn metered(device: &Device, name: &str, words: Vec<u32>, constants: &[u32]) -> Result<Self> {
        let Some(counted) = count::counted(&words) else { return Self::new(device, name, words, constants) };
        let mut kernel = Self::new(device, name, counted.words, constants)?;
        let counters = Buffer::new(device, "counters", 8 * counted.blocks.len() as u64)?;
        counters.upload(&vec![0; 8 * counted.blocks.len()])?;
        kernel.meter = Some(Meter { blocks: counted.blocks, counters });
        Ok(kernel)
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
    pub(super) fn new(device: &Device, name: &str, mut words: Vec<u32>, constants: &[u32]) -> Result<Self> {
        let doing = format!("preparing kernel {name}");
        let found = reflect(name, &words)?;

        // What the device must allow.
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
        if limits.round_to_nearest {
            words = round_to_nearest(words);
        }

        let mut kernel = Self {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            name: name.to_string(),
            accesses: found.accesses,
            push_bytes: found.push_bytes,
            group: found.group,
            meter: None,
            device: device.0.clone(),
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
        let raw = &device.0.raw;
        // SAFETY: every handle is this device's and lands in `kernel` at once, which frees it if a later step fails.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            kernel.set_layout =
                tried("vkCreateDescriptorSetLayout", &doing, || raw.create_descriptor_set_layout(&info, None))?;
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
            kernel.layout = tried("vkCreatePipelineLayout", &doing, || raw.create_pipeline_layout(&info, None))?;
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            let module = tried("vkCreateShaderModule", &doing, || raw.create_shader_module(&info, None))?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main")
                .specialization_info(&special);
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(kernel.layout)];
            let made = tried("vkCreateComputePipelines", &doing, || {
                raw.create_compute_pipelines(device.0.cache, &info, None).map_err(|(_, code)| code)
            });
            raw.destroy_shader_module(module, None);
            kernel.pipeline = made?[0];
        }
        device.label(kernel.pipeline, name);
        Ok(kernel)
    }
}

impl Drop for Kernel {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        let raw = &self.device.raw;
        // SAFETY: every submission is waited for, so the device no longer uses them; null handles are allowed.
        unsafe {
            raw.destroy_pipeline(self.pipeline, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
