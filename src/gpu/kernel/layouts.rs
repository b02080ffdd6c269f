//! The layouts of a kernel's descriptor sets and of its pipeline.

use ash::vk;

use super::Kernel;
use crate::error::Result;
use crate::gpu::call::vk_call;
use crate::gpu::choices::{Constants, Descriptors};
use crate::gpu::count;
use crate::layout::BUFFER_IDS;

impl Kernel {
    /// Makes the layouts of its sets and of its pipeline.
    pub(super) fn make_layouts(&mut self, doing: &str) -> Result<()> {
        let (raw, choices) = (self.device.raw(), self.device.choices());
        let numbers: Vec<u32> = match choices.descriptors {
            Descriptors::Frame => (0..BUFFER_IDS.len() as u32).chain([count::BINDING]).collect(),
            _ => self.accesses.iter().map(|access| access.binding).collect(),
        };
        let binding = |number: u32, kind: vk::DescriptorType| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(number)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let bindings: Vec<_> =
            numbers.into_iter().map(|number| binding(number, vk::DescriptorType::STORAGE_BUFFER)).collect();
        let unused = vk::DescriptorBindingFlags::PARTIALLY_BOUND | vk::DescriptorBindingFlags::UPDATE_AFTER_BIND;
        let flags = vec![unused; bindings.len()];
        let mut flags = vk::DescriptorSetLayoutBindingFlagsCreateInfo::default().binding_flags(&flags);
        let mut info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        match choices.descriptors {
            Descriptors::Frame => {
                let whole = vk::DescriptorSetLayoutCreateFlags::UPDATE_AFTER_BIND_POOL;
                info = info.flags(whole).push_next(&mut flags);
            }
            Descriptors::Push => info = info.flags(vk::DescriptorSetLayoutCreateFlags::PUSH_DESCRIPTOR_KHR),
            Descriptors::Shared | Descriptors::Dispatch => {}
        }
        // SAFETY: every handle is this device's and is stored in `self` at once, which frees it after a failure.
        unsafe {
            self.set_layout =
                vk_call("vkCreateDescriptorSetLayout", doing, || raw.create_descriptor_set_layout(&info, None))?;
            self.device.label(self.set_layout, format_args!("buffers of {}", self.name));
            let mut sets = vec![self.set_layout];
            if choices.constants == Constants::Uniform && self.push_bytes > 0 {
                let constants = [binding(0, vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC)];
                let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&constants);
                self.uniform_layout =
                    vk_call("vkCreateDescriptorSetLayout", doing, || raw.create_descriptor_set_layout(&info, None))?;
                self.device.label(self.uniform_layout, format_args!("constants of {}", self.name));
                sets.push(self.uniform_layout);
            }
            // Sets stay bound from one kernel to the next only where the layouts have the same push constants.
            let size = match (choices.constants, choices.descriptors) {
                (Constants::Push, Descriptors::Frame) => self.device.limits().push_bytes,
                (Constants::Push, _) => self.push_bytes,
                _ => 0,
            };
            let push =
                [vk::PushConstantRange { stage_flags: vk::ShaderStageFlags::COMPUTE, offset: 0, size: size.max(4) }];
            let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            if size > 0 {
                info = info.push_constant_ranges(&push);
            }
            self.layout = vk_call("vkCreatePipelineLayout", doing, || raw.create_pipeline_layout(&info, None))?;
            self.device.label(self.layout, format_args!("layout of {}", self.name));
        }
        Ok(())
    }
}
