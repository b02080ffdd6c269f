//! What a device offers beyond what each has to offer: some [`Choices`] need it.

use std::ffi::CStr;

use ash::{ext, khr, vk};

use super::choices::{Barriers, Choices, Descriptors, MemoryKind, Queues};
use crate::layout::BUFFER_IDS;

/// What a device offers for [`Choices`].
#[derive(Clone, Debug, Default)]
pub struct Offers {
    /// Buffers that can be pushed for a dispatch; 0 without `VK_KHR_push_descriptor`.
    push_descriptors: u32,
    /// Whether it has `VK_KHR_synchronization2`.
    synchronization2: bool,
    /// The smallest and the largest subgroup size that a pipeline can require; none without
    /// `VK_EXT_subgroup_size_control`.
    pub(super) subgroups: Option<[u32; 2]>,
    /// The most subgroups of a required size in a group.
    pub(super) most_subgroups: u32,
    /// Whether a pipeline can require that all subgroups are full, by the same extension.
    pub(super) full_subgroups: bool,
    /// Whether kernels can shuffle values in a subgroup.
    pub(super) shuffles: bool,
    /// Storage buffers in a set that is bound once for all kernels; 0 where it can't have unused ones.
    set_buffers: u32,
    /// Whether its compiler reports on pipelines: `VK_KHR_pipeline_executable_properties`.
    pub(super) statistics: bool,
    /// Whether it is a driver of a part of Vulkan, which has to be opened as such: `VK_KHR_portability_subset`.
    pub(super) portability_subset: bool,
    /// The extension by which its clock can be read.
    pub(super) clock: Option<&'static CStr>,
    /// How many queues the family of its compute queue has.
    queues: u32,
    /// Whether it has timeline semaphores.
    timelines: bool,
    /// The memory types of buffers that are local, visible, and cached.
    memory_types: [Option<usize>; 3],
    /// Whether some memory is the device's own and seen by the host, too.
    pub(super) local_visible: bool,
}

impl Offers {
    /// What an instance says of one of its physical devices, whose compute queue is of this family.
    pub(super) fn query(
        entry: &ash::Entry,
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        family: u32,
    ) -> Self {
        // SAFETY: a plain query on a device of this instance.
        let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str().is_ok_and(|known| known == name));
        let mut operations = vk::PhysicalDeviceSubgroupProperties::default();
        let mut subgroups = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
        let mut sizes = vk::PhysicalDeviceSubgroupSizeControlFeatures::default();
        let mut pushes = vk::PhysicalDevicePushDescriptorPropertiesKHR::default();
        let mut indexing = vk::PhysicalDeviceDescriptorIndexingProperties::default();
        let mut timeline = vk::PhysicalDeviceTimelineSemaphoreFeatures::default();
        let mut binding = vk::PhysicalDeviceDescriptorIndexingFeatures::default();
        let mut second = vk::PhysicalDeviceSynchronization2Features::default();
        let mut properties =
            vk::PhysicalDeviceProperties2::default().push_next(&mut indexing).push_next(&mut operations);
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut binding).push_next(&mut timeline);
        if has(ext::subgroup_size_control::NAME) {
            properties = properties.push_next(&mut subgroups);
            features = features.push_next(&mut sizes);
        }
        if has(khr::push_descriptor::NAME) {
            properties = properties.push_next(&mut pushes);
        }
        if has(khr::synchronization2::NAME) {
            features = features.push_next(&mut second);
        }
        // SAFETY: the chains live through the calls, and the device knows each structure.
        let (memory, families) = unsafe {
            instance.get_physical_device_properties2(physical, &mut properties);
            instance.get_physical_device_features2(physical, &mut features);
            (
                instance.get_physical_device_memory_properties(physical),
                instance.get_physical_device_queue_family_properties(physical),
            )
        };
        let stages = subgroups.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE);
        let sized = sizes.subgroup_size_control == vk::TRUE && stages;
        let partial = binding.descriptor_binding_partially_bound == vk::TRUE
            && binding.descriptor_binding_storage_buffer_update_after_bind == vk::TRUE;
        Self {
            push_descriptors: pushes.max_push_descriptors,
            synchronization2: second.synchronization2 == vk::TRUE,
            subgroups: sized.then_some([subgroups.min_subgroup_size, subgroups.max_subgroup_size]),
            most_subgroups: subgroups.max_compute_workgroup_subgroups,
            shuffles: operations.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
                && operations
                    .supported_operations
                    .contains(vk::SubgroupFeatureFlags::BASIC | vk::SubgroupFeatureFlags::SHUFFLE),
            full_subgroups: sizes.compute_full_subgroups == vk::TRUE,
            set_buffers: match partial {
                true => indexing
                    .max_per_stage_descriptor_update_after_bind_storage_buffers
                    .min(indexing.max_descriptor_set_update_after_bind_storage_buffers),
                false => 0,
            },
            queues: families.get(family as usize).map_or(0, |family| family.queue_count),
            statistics: has(khr::pipeline_executable_properties::NAME),
            portability_subset: has(khr::portability_subset::NAME),
            clock: CLOCKS.into_iter().find(|name| has(name) && reads_clock(entry, instance, physical, name)),
            timelines: timeline.timeline_semaphore == vk::TRUE,
            memory_types: memory_types(memory.memory_types_as_slice()),
            local_visible: memory.memory_types_as_slice().iter().any(is_local_visible),
        }
    }

    /// Why a device of this kind can't do as a program chooses, if it can't.
    #[must_use]
    pub fn lack(&self, choices: &Choices) -> Option<String> {
        if let Some(size) = choices.subgroup {
            match self.subgroups {
                None => return Some("it lacks VK_EXT_subgroup_size_control".into()),
                Some([least, most]) if !(least..=most).contains(&size) => {
                    return Some(format!("it has subgroups of {least} to {most}"));
                }
                Some(_) => {}
            }
        }
        let types = self.memory_types;
        let [local, wanted] = match choices.memory {
            MemoryKind::Local | MemoryKind::Dedicated => [Some(0), Some(1)],
            MemoryKind::Visible => [types[0], types[1]],
            MemoryKind::Cached => [types[0], types[2]],
        };
        let buffers = BUFFER_IDS.len() as u32 + 1;
        let lack = match (choices.descriptors, choices.barriers) {
            (Descriptors::Push, _) if self.push_descriptors == 0 => "it lacks VK_KHR_push_descriptor",
            (Descriptors::Frame, _) if self.set_buffers < buffers => {
                "it lacks descriptorBindingPartiallyBound with descriptorBindingStorageBufferUpdateAfterBind"
            }
            (_, Barriers::Synchronization2) if !self.synchronization2 => "it lacks VK_KHR_synchronization2",
            (_, Barriers::Events) if self.portability_subset => "it has a part of Vulkan, which may lack events",
            _ if choices.queues != Queues::One && !self.timelines => "it lacks timelineSemaphore",
            _ if choices.queues == Queues::Two && self.queues < 2 => "the family of its compute queue has one queue",
            _ if wanted.is_none() => "it has no such memory type",
            _ if wanted == local => "it is the memory type of local",
            _ => return None,
        };
        Some(lack.into())
    }
}

/// Whether the device's own clock is one of those that this extension of it reads.
fn reads_clock(entry: &ash::Entry, instance: &ash::Instance, physical: vk::PhysicalDevice, extension: &CStr) -> bool {
    use ext::calibrated_timestamps::Instance as OfExt;
    use khr::calibrated_timestamps::Instance as OfKhr;
    // SAFETY: a plain query on a device of this instance that has the extension.
    let clocks = unsafe {
        match extension == khr::calibrated_timestamps::NAME {
            true => OfKhr::new(entry, instance).get_physical_device_calibrateable_time_domains(physical),
            false => OfExt::new(entry, instance).get_physical_device_calibrateable_time_domains(physical),
        }
    };
    clocks.is_ok_and(|clocks| clocks.contains(&vk::TimeDomainKHR::DEVICE))
}

/// Extensions that read a device's clock.
const CLOCKS: [&CStr; 2] = [khr::calibrated_timestamps::NAME, ext::calibrated_timestamps::NAME];

/// Properties of memory that is the device's own and that the host sees.
const LOCAL_VISIBLE: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::from_raw(
    vk::MemoryPropertyFlags::DEVICE_LOCAL.as_raw()
        | vk::MemoryPropertyFlags::HOST_VISIBLE.as_raw()
        | vk::MemoryPropertyFlags::HOST_COHERENT.as_raw(),
);

fn is_local_visible(kind: &vk::MemoryType) -> bool {
    kind.property_flags.contains(LOCAL_VISIBLE)
}

/// The first type for each location as the allocator chooses it.
fn memory_types(types: &[vk::MemoryType]) -> [Option<usize>; 3] {
    use vk::MemoryPropertyFlags as Flags;
    let visible = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
    let first = |wanted: Flags| types.iter().position(|kind| kind.property_flags.contains(wanted));
    [
        first(Flags::DEVICE_LOCAL),
        first(visible | Flags::DEVICE_LOCAL).or(first(visible)),
        first(visible | Flags::HOST_CACHED),
    ]
}
