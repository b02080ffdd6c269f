//! A compute kernel: a pipeline made from SPIR-V, and what it binds.

mod layouts;
mod meter;
mod shape;
mod subgroups;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::{Duration, Instant};

use ash::vk;

use super::call::vk_call;
use super::choices::Constants;
use super::logical_device::LogicalDevice;
use super::pushed::{BAKED_ID, as_specialization, as_uniform};
use super::reflect::{Access, Reflected, has_subgroups, reflect, words_of, words_without_subgroups};
use super::spirv_module::{round_to_nearest, without_rounding};
use crate::error::{Error, Result};
use crate::layout::{GROUPS_A_ROW, LOCKSTEP_ID};
use crate::phases::phase;

pub(super) use meter::Meter;
pub(super) use shape::Shape;
#[cfg(feature = "measure")]
pub(crate) use shape::most_lanes;
pub use shape::set_by_device;
pub(super) use subgroups::words_for;

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
    /// Its specialization constants 0, 1, ...
    pub(super) constants: Vec<u32>,
    /// The buffers it binds, by binding.
    pub accesses: Vec<Access>,
    /// Bytes of push constants it takes.
    pub push_bytes: u32,
    /// Whether it shares values in subgroups, and takes for granted that they are full.
    shuffles: bool,
    /// Whether it has the specialization constant that says whether subgroups run in lockstep.
    asks_lockstep: bool,
    /// Whether its SPIR-V is the build's; a user's kernel may take fewer constants than it is given.
    pub(super) built: bool,
    /// How long the driver took to create the pipeline.
    pub creation: Duration,
    /// Invocations of a group.
    pub group: u32,
    /// How many of them a group has along its first dimension.
    across: u32,
    /// Its groups where the device sets them.
    pub(super) shape: Shape,
    /// Its counters, if it counts what it does.
    pub(super) meter: Option<Meter>,
    /// The layout of the set of its push constants, where these are a uniform buffer.
    pub(super) uniform_layout: vk::DescriptorSetLayout,
    /// What it was made from, and the kernels that were made from it for some values of its push constants.
    source: Option<Box<Source>>,
    pub(super) device: LogicalDevice,
}

/// What a kernel whose push constants become specialization constants was made from.
struct Source {
    words: Vec<u32>,
    constants: Vec<u32>,
    baked: RefCell<BTreeMap<Vec<u8>, Rc<Kernel>>>,
}

impl Kernel {
    /// The groups of a dispatch of this many items: all in one row where they fit, else rows of equal length.
    pub(crate) fn grid(&self, items: u64) -> [u32; 3] {
        let groups = (items * u64::from(self.shape.an_item())).div_ceil(u64::from(self.group));
        let row = u64::from(GROUPS_A_ROW).min(self.device.limits().groups[0].into()).max(1);
        [groups.min(row), groups.div_ceil(row), 1].map(|count| u32::try_from(count).unwrap_or(u32::MAX))
    }

    /// The kernel of this SPIR-V with these specialization constants (0, 1, ...), or what the device lacks for it.
    pub(crate) fn new(device: &LogicalDevice, name: &str, words: Vec<u32>, constants: &[u32]) -> Result<Self> {
        let (shape, shuffles) = (Shape::of(device, name, &*reflect(name, &words)?), has_subgroups(&words));
        Self::shaped(device, name, words, constants, (shape, shuffles))
    }

    fn shaped(
        device: &LogicalDevice,
        name: &str,
        words: Vec<u32>,
        constants: &[u32],
        (shape, shuffles): (Shape, bool),
    ) -> Result<Self> {
        let special: Vec<(u32, u32)> = (0..).zip(constants.iter().copied()).collect();
        let kept = device.choices().constants == Constants::Specialization;
        let source =
            kept.then(|| Source { words: words.clone(), constants: constants.to_vec(), baked: RefCell::default() });
        let mut kernel = Self::described(device, name, &words, constants, shape)?;
        kernel.shuffles = shuffles;
        kernel.source = source.filter(|_| kernel.push_bytes > 0).map(Box::new);
        // Where push constants become specialization constants, `baked` makes a pipeline for each of their values.
        match kernel.source {
            Some(_) => Ok(kernel),
            None => kernel.with_pipeline(words, special),
        }
    }

    /// The kernel with these push constants as specialization constants, or this one where it does not need that.
    pub(super) fn baked(self: &Rc<Self>, push: &[u8]) -> Result<Rc<Self>> {
        let Some(source) = &self.source else { return Ok(self.clone()) };
        if let Some(known) = source.baked.borrow().get(push) {
            return Ok(known.clone());
        }
        let words = as_specialization(&source.words, 0).ok_or_else(|| {
            Error::device(format!("preparing kernel {}", self.name), "it takes push constants by an index")
        })?;
        let mut special: Vec<(u32, u32)> = (0..).zip(source.constants.iter().copied()).collect();
        let pushed = push.chunks_exact(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
        special.extend((BAKED_ID..).zip(pushed));
        let mut made = Self::described(&self.device, &self.name, &words, &source.constants, self.shape)?;
        made.shuffles = self.shuffles;
        let made = Rc::new(made.with_pipeline(words, special)?);
        source.baked.borrow_mut().insert(push.to_vec(), made.clone());
        Ok(made)
    }

    /// What this SPIR-V says of itself, for these specialization constants; it has no pipeline yet.
    fn described(device: &LogicalDevice, name: &str, words: &[u32], constants: &[u32], shape: Shape) -> Result<Self> {
        let found = reflect(name, words)?;
        let group = shape.group.unwrap_or(found.group);
        let built = words_of(name).is_ok_and(|known| known == words)
            || words_without_subgroups(name).is_some_and(|known| known == words);
        check(device, &found, group, (constants.len(), built), &format!("preparing kernel {name}"))?;
        Ok(Self {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            uniform_layout: vk::DescriptorSetLayout::null(),
            name: name.to_string(),
            constants: constants.to_vec(),
            shuffles: has_subgroups(words),
            asks_lockstep: found.constants.contains_key(&LOCKSTEP_ID),
            accesses: found.accesses.clone(),
            push_bytes: found.push_bytes,
            built,
            group,
            across: shape.group.unwrap_or(found.across),
            shape,
            creation: Duration::ZERO,
            meter: None,
            source: None,
            device: device.clone(),
        })
    }

    /// The same with a pipeline, with these specialization constants by their ids.
    fn with_pipeline(mut self, words: Vec<u32>, mut special: Vec<(u32, u32)>) -> Result<Self> {
        let doing = format!("preparing kernel {}", self.name);
        let device = self.device.clone();
        let choices = device.choices();
        special.extend(self.shape.constants());
        special.extend((self.asks_lockstep && device.adapter().is_llvmpipe()).then_some((LOCKSTEP_ID, 1)));
        let uniform = choices.constants == Constants::Uniform;
        let words = as_given(&device, if uniform { as_uniform(&words) } else { words });
        self.make_layouts(&doing)?;
        let entries: Vec<_> = special
            .iter()
            .zip(0..)
            .map(|((id, _), at)| vk::SpecializationMapEntry { constant_id: *id, offset: 4 * at, size: 4 })
            .collect();
        let values: Vec<u32> = special.iter().map(|(_, value)| *value).collect();
        let special = vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
        let raw = device.raw();
        // SAFETY: every handle is this device's. The module is destroyed once the pipeline is made or refused; all
        // others are in `self`, which frees them.
        unsafe {
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            let module = vk_call("vkCreateShaderModule", &doing, || raw.create_shader_module(&info, None))?;
            device.label(module, &self.name);
            let mut size = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default();
            let mut stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main")
                .specialization_info(&special);
            // Invocations that share a subgroup find each other by their place in it: there has to be one at each.
            if self.shuffles && device.grants_full_subgroups(self.across) {
                stage = stage.flags(vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS);
            }
            // Groups that take more subgroups of that size than a group can have do without, unless they shuffle.
            let most = device.adapter().offers.most_subgroups;
            let fits = |size: &u32| self.shuffles || self.group <= size.saturating_mul(most);
            if let Some(subgroup) = device.subgroup(self.shuffles).filter(fits) {
                size = size.required_subgroup_size(subgroup);
                stage = stage.push_next(&mut size);
            }
            let keeps = |asked: bool, flag: vk::PipelineCreateFlags| if asked { flag } else { Default::default() };
            let flags = keeps(device.extras().statistics, vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR)
                | keeps(device.extras().code, vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR);
            let info = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(self.layout)];
            let begin = Instant::now();
            let made = phase("making pipelines", || {
                vk_call("vkCreateComputePipelines", &doing, || {
                    raw.create_compute_pipelines(device.pipeline_cache(), &info, None).map_err(|(_, code)| code)
                })
            });
            self.creation = begin.elapsed();
            raw.destroy_shader_module(module, None);
            self.pipeline = made?[0];
        }
        device.label(self.pipeline, &self.name);
        Ok(self)
    }
}

/// A module as the driver is given it: with a request to round to nearest, where the device takes one.
pub(super) fn as_given(device: &LogicalDevice, words: Vec<u32>) -> Vec<u32> {
    let words = without_rounding(&words);
    if device.limits().round_to_nearest { round_to_nearest(words) } else { words }
}

/// Fails where the device allows less than a kernel needs, or where the number of constants is not the kernel's.
fn check(
    device: &LogicalDevice,
    found: &Reflected,
    group: u32,
    (given, built): (usize, bool),
    doing: &str,
) -> Result<()> {
    let limits = device.limits();
    let count = u32::try_from(found.accesses.len()).unwrap_or(u32::MAX);
    for (what, needed, allowed) in [
        ("storage buffers", count, limits.storage_buffers),
        ("bytes of push constants", found.push_bytes, limits.push_bytes),
        ("invocations in a group", group, limits.group_invocations),
    ] {
        if needed > allowed {
            return Err(Error::device(doing, format!("it needs {needed} {what}, the device allows {allowed}")));
        }
    }
    // SPIR-V that was not optimised has constants that nothing uses; a user's may leave out some.
    let has = found.set_by_program().count();
    if has != given && built {
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
            raw.destroy_descriptor_set_layout(self.uniform_layout, None);
        }
    }
}
