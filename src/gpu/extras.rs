//! What a device is opened with beyond what the program's own kernels need: features that a user's shader declares by
//! its capabilities, and what the driver's compiler says of pipelines.

use std::collections::BTreeSet;

use ash::vk;
use spirq::spirv::{Capability, Op};

use super::spirv_module::instructions;

/// What a device is opened with on request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Extras {
    /// Features by their names in the specification, those of [`FEATURES`] only.
    pub(super) features: BTreeSet<&'static str>,
    /// Whether pipelines keep what the driver's compiler says of them; the driver has to offer that.
    pub(super) statistics: bool,
    /// Whether they keep their code, too, as the compiler wrote it; only with `statistics`.
    pub(super) code: bool,
}

/// Features as structs that a call fills, or that a device is opened with.
#[derive(Default)]
pub(super) struct Features {
    pub(super) core: vk::PhysicalDeviceFeatures,
    pub(super) eleven: vk::PhysicalDeviceVulkan11Features<'static>,
    pub(super) twelve: vk::PhysicalDeviceVulkan12Features<'static>,
    pub(super) statistics: vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR<'static>,
}

/// A feature that a capability of a module needs.
struct Feature {
    capability: Capability,
    name: &'static str,
    bit: fn(&mut Features) -> &mut vk::Bool32,
}

macro_rules! features {
    ($($capability:ident $name:literal $part:ident . $field:ident;)*) => {
        /// The capabilities that need a feature, and which one.
        const FEATURES: &[Feature] = &[$(Feature {
            capability: Capability::$capability,
            name: $name,
            bit: |features| &mut features.$part.$field,
        }),*];
    };
}

features! {
    Float64 "shaderFloat64" core.shader_float64;
    Int64 "shaderInt64" core.shader_int64;
    Int16 "shaderInt16" core.shader_int16;
    StorageBuffer16BitAccess "storageBuffer16BitAccess" eleven.storage_buffer16_bit_access;
    UniformAndStorageBuffer16BitAccess
        "uniformAndStorageBuffer16BitAccess" eleven.uniform_and_storage_buffer16_bit_access;
    StoragePushConstant16 "storagePushConstant16" eleven.storage_push_constant16;
    VariablePointersStorageBuffer "variablePointersStorageBuffer" eleven.variable_pointers_storage_buffer;
    Float16 "shaderFloat16" twelve.shader_float16;
    Int8 "shaderInt8" twelve.shader_int8;
    StorageBuffer8BitAccess "storageBuffer8BitAccess" twelve.storage_buffer8_bit_access;
    UniformAndStorageBuffer8BitAccess "uniformAndStorageBuffer8BitAccess" twelve.uniform_and_storage_buffer8_bit_access;
    StoragePushConstant8 "storagePushConstant8" twelve.storage_push_constant8;
    Int64Atomics "shaderBufferInt64Atomics" twelve.shader_buffer_int64_atomics;
    VulkanMemoryModel "vulkanMemoryModel" twelve.vulkan_memory_model;
    VulkanMemoryModelDeviceScope "vulkanMemoryModelDeviceScope" twelve.vulkan_memory_model_device_scope;
}

impl Extras {
    /// The features of a device with these extras. `statistics` are those of an extension: a device may be opened with
    /// them only together with that.
    pub(super) fn features(&self) -> Features {
        let mut features = Features::default();
        features.twelve.scalar_block_layout = vk::TRUE;
        features.statistics.pipeline_executable_info = self.statistics.into();
        for feature in FEATURES.iter().filter(|feature| self.features.contains(feature.name)) {
            *(feature.bit)(&mut features) = vk::TRUE;
        }
        features
    }
}

impl Features {
    /// The features that an adapter offers, except `statistics`.
    pub(super) fn query(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Self {
        let mut found = Self::default();
        let mut features =
            vk::PhysicalDeviceFeatures2::default().push_next(&mut found.eleven).push_next(&mut found.twelve);
        // SAFETY: the adapter is of this instance, and of version 1.2 or newer.
        unsafe { instance.get_physical_device_features2(physical, &mut features) };
        found.core = features.features;
        found
    }

    fn has(&mut self, name: &str) -> bool {
        FEATURES.iter().any(|feature| feature.name == name && *(feature.bit)(self) == vk::TRUE)
    }

    /// Those that are there.
    #[cfg(feature = "measure")]
    pub(super) fn all(&mut self) -> impl Iterator<Item = &'static str> {
        let found: Vec<_> = FEATURES.iter().map(|feature| feature.name).filter(|name| self.has(name)).collect();
        found.into_iter()
    }

    /// The first of these features that is missing, and the capability that needs it.
    pub(super) fn lacking(&mut self, needed: &[(Capability, &'static str)]) -> Option<(Capability, &'static str)> {
        needed.iter().copied().find(|(_, name)| !self.has(name))
    }
}

/// The capabilities of a module that need a feature, each with that feature; or the name of one that the program has
/// no feature for.
pub(super) fn needed(words: &[u32]) -> Result<Vec<(Capability, &'static str)>, String> {
    let mut found = Vec::new();
    for instruction in instructions(words).filter(|instruction| instruction.op == Some(Op::Capability)) {
        let number = instruction.operands.first().copied().unwrap_or_default();
        let Some(capability) = Capability::from_u32(number) else { return Err(format!("number {number}")) };
        match FEATURES.iter().find(|feature| feature.capability == capability) {
            Some(feature) => found.push((capability, feature.name)),
            None if free(capability) => {}
            None => return Err(format!("{capability:?}")),
        }
    }
    Ok(found)
}

/// Whether a capability needs no feature: it is core, or a property says where it holds.
fn free(capability: Capability) -> bool {
    let name = format!("{capability:?}");
    let properties = ["GroupNonUniform", "Denorm", "SignedZeroInfNanPreserve", "RoundingMode"];
    matches!(capability, Capability::Shader | Capability::Matrix)
        || properties.iter().any(|start| name.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::spirv_module::module_of;

    #[test]
    fn capabilities_name_their_features() {
        let declaring = |capabilities: &[Capability]| {
            let numbers: Vec<[u32; 1]> = capabilities.iter().map(|capability| [*capability as u32]).collect();
            let list: Vec<(Op, &[u32])> = numbers.iter().map(|number| (Op::Capability, &number[..])).collect();
            needed(&module_of(&list)).map(|found| found.into_iter().map(|(_, name)| name).collect::<Vec<_>>())
        };
        use Capability::{Float16, Geometry, GroupNonUniformBallot, Int64, RoundingModeRTE, Shader};
        assert_eq!(declaring(&[Shader, GroupNonUniformBallot, RoundingModeRTE]), Ok(vec![]));
        assert_eq!(declaring(&[Shader, Float16, Int64]), Ok(vec!["shaderFloat16", "shaderInt64"]));
        assert_eq!(declaring(&[Shader, Geometry]), Err("Geometry".into()));
        let extras = Extras { features: ["shaderInt64"].into(), ..Extras::default() };
        let mut features = extras.features();
        let wanted = [(Int64, "shaderInt64"), (Float16, "shaderFloat16")];
        assert_eq!(features.lacking(&wanted), Some((Float16, "shaderFloat16")));
        assert_eq!(features.lacking(&wanted[..1]), None);
        assert!(features.twelve.scalar_block_layout == vk::TRUE);
    }
}
