//! Compute kernels: the SPIR-V of the build, what it binds by reflection, and pipelines made when first used.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use ash::vk;
use spirq::prelude::*;
use spirq::spirv::ExecutionMode;
use spirq::ty::{AccessType, DescriptorType, Type};

use super::device::Device;
use super::fault;
use crate::error::{Error, Result};

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));

/// What a kernel does with a buffer, as declared in GLSL by `readonly` and `writeonly`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// The binding.
    pub binding: u32,
    /// Whether it reads.
    pub reads: bool,
    /// Whether it writes.
    pub writes: bool,
}

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
    device: Device,
}

/// The kernels of a device, each made when first asked for.
pub struct Kernels {
    device: Device,
    made: RefCell<BTreeMap<(String, Vec<u32>), Rc<Kernel>>>,
}

/// The names of all kernels in the program.
pub fn kernel_names() -> impl Iterator<Item = &'static str> {
    SPIRV.iter().map(|(name, _)| *name)
}

fn words_of(name: &str) -> Result<Vec<u32>> {
    let (_, bytes) = SPIRV
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| Error::device(format!("looking for kernel {name}"), "no such shader was built"))?;
    Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

/// What reflection finds in a kernel.
struct Reflected {
    accesses: Vec<Access>,
    types: Vec<Type>,
    push_bytes: u32,
    group: u32,
    constants: usize,
}

fn reflect(name: &str, words: &[u32]) -> Result<Reflected> {
    let doing = || format!("reading kernel {name}");
    let entries = ReflectConfig::new()
        .spv(words)
        .ref_all_rscs(false)
        .reflect()
        .map_err(|error| Error::device(doing(), format!("{error:?}")))?;
    let entry = entries.first().ok_or_else(|| Error::device(doing(), "it has no entry point"))?;
    let mut found = Reflected { accesses: Vec::new(), types: Vec::new(), push_bytes: 0, group: 0, constants: 0 };
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { desc_bind, desc_ty: DescriptorType::StorageBuffer(access), ty, .. } => {
                found.accesses.push(Access {
                    binding: desc_bind.bind(),
                    reads: *access != AccessType::WriteOnly,
                    writes: *access != AccessType::ReadOnly,
                });
                found.types.push(ty.clone());
            }
            Variable::Descriptor { name: which, .. } => {
                return Err(Error::device(doing(), format!("{which:?} is no storage buffer")));
            }
            Variable::PushConstant { ty, .. } => {
                found.push_bytes = u32::try_from(ty.nbyte().unwrap_or(0)).unwrap_or(u32::MAX);
                found.types.push(ty.clone());
            }
            Variable::SpecConstant { .. } => found.constants += 1,
            _ => {}
        }
    }
    found.accesses.sort_by_key(|access| access.binding);
    for mode in &entry.exec_modes {
        if mode.exec_mode == ExecutionMode::LocalSize {
            let sizes = mode.operands.iter().filter_map(|operand| operand.value.to_typeless());
            found.group = sizes.filter_map(|b| Some(u32::from_le_bytes(b.get(..4)?.try_into().ok()?))).product();
        }
    }
    if found.group == 0 {
        return Err(Error::device(doing(), "it does not state its group size"));
    }
    Ok(found)
}

/// Every struct in the SPIR-V of every kernel: kernel, struct name, and each member's name and byte offset; then
/// every runtime array's element struct with its stride as a member called `[]`.
pub fn reflect_records() -> Result<Vec<(String, String, Vec<(String, usize)>)>> {
    fn visit(kernel: &str, ty: &Type, out: &mut Vec<(String, String, Vec<(String, usize)>)>) {
        match ty {
            Type::Struct(record) => {
                let members = record
                    .members
                    .iter()
                    .map(|m| (m.name.clone().unwrap_or_default(), m.offset.unwrap_or(usize::MAX)))
                    .collect();
                out.push((kernel.to_string(), record.name.clone().unwrap_or_default(), members));
                for member in &record.members {
                    visit(kernel, &member.ty, out);
                    if let Type::Array(array) = &member.ty {
                        let name = match &*array.element_ty {
                            Type::Struct(element) => element.name.clone().unwrap_or_default(),
                            _ => member.name.clone().unwrap_or_default(),
                        };
                        out.push((kernel.to_string(), name, vec![("[]".into(), array.stride.unwrap_or(0))]));
                    }
                }
            }
            Type::Array(array) => visit(kernel, &array.element_ty, out),
            _ => {}
        }
    }
    let mut out = Vec::new();
    for name in kernel_names() {
        for ty in reflect(name, &words_of(name)?)?.types {
            visit(name, &ty, &mut out);
        }
    }
    Ok(out)
}

/// Asks for 32-bit rounding to nearest: a capability after the header, an execution mode before the first one.
fn round_to_nearest(mut words: Vec<u32>) -> Vec<u32> {
    const OP_ENTRY_POINT: u32 = 15;
    const OP_EXECUTION_MODE: u32 = 16;
    let mut at = 5;
    let mut entry = 0;
    while at < words.len() {
        let (op, length) = (words[at] & 0xffff, (words[at] >> 16).max(1) as usize);
        if op == OP_ENTRY_POINT {
            entry = words[at + 2];
        }
        if op == OP_EXECUTION_MODE {
            words.splice(at..at, [(4 << 16) | OP_EXECUTION_MODE, entry, 4462, 32]);
            words.splice(5..5, [(2 << 16) | 17, 4467]);
            return words;
        }
        at += length;
    }
    words
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
        let kernel = Rc::new(Kernel::new(&self.device, name, constants)?);
        self.made.borrow_mut().insert(key, kernel.clone());
        Ok(kernel)
    }
}

impl Kernel {
    fn new(device: &Device, name: &str, constants: &[u32]) -> Result<Self> {
        let doing = format!("preparing kernel {name}");
        let mut words = words_of(name)?;
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
        let raw = &device.0.raw;
        // SAFETY: every handle is this device's and lands in `kernel` at once, which frees it if a later step fails.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            kernel.set_layout = raw.create_descriptor_set_layout(&info, None).map_err(|code| fault(&doing, code))?;
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
            kernel.layout = raw.create_pipeline_layout(&info, None).map_err(|code| fault(&doing, code))?;
            let module = raw
                .create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)
                .map_err(|code| fault(&doing, code))?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main")
                .specialization_info(&special);
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(kernel.layout)];
            let made = raw.create_compute_pipelines(device.0.cache, &info, None);
            raw.destroy_shader_module(module, None);
            kernel.pipeline = made.map_err(|(_, code)| fault(&doing, code))?[0];
        }
        device.label(kernel.pipeline, name);
        Ok(kernel)
    }
}

impl Drop for Kernel {
    fn drop(&mut self) {
        let raw = &self.device.0.raw;
        // SAFETY: every submission is waited for, so the device no longer uses them; null handles are allowed.
        unsafe {
            raw.destroy_pipeline(self.pipeline, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
