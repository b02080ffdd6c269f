//! Creating a device with the features and extensions that it needs.

use std::ffi::{CStr, c_char};

use ash::{ext, khr, vk};

use super::super::adapter::Adapter;
use super::super::call::vk_call;
use super::super::choices::{Barriers, Choices, Descriptors, Queues};
use super::super::extras::Extras;
use super::super::instance::Instance;
use super::super::offers::Offers;
use crate::error::Result;

/// What is being done, for errors.
pub(super) fn opening(adapter: &Adapter) -> String {
    format!("opening {}", adapter.name)
}

/// Creates the device, and finds its queues.
pub(super) fn create(
    instance: &Instance,
    adapter: &Adapter,
    choices: &Choices,
    extras: &Extras,
) -> Result<(ash::Device, [vk::Queue; 2])> {
    let priorities = [1.0; 2];
    let count = if choices.queues == Queues::Two { 2 } else { 1 };
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(adapter.queue_family)
        .queue_priorities(&priorities[..count])];

    // What the choices and the extras need, full subgroups where there are any, and nothing else.
    let mut features = extras.features();
    features.twelve.timeline_semaphore = (choices.queues != Queues::One).into();
    let mut second = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
    let full = adapter.offers.full_subgroups;
    let mut sizes = vk::PhysicalDeviceSubgroupSizeControlFeatures::default()
        .subgroup_size_control(choices.subgroup.or(adapter.narrower()).is_some())
        .compute_full_subgroups(full);
    if choices.descriptors == Descriptors::Frame {
        features.twelve.descriptor_binding_partially_bound = vk::TRUE;
        features.twelve.descriptor_binding_storage_buffer_update_after_bind = vk::TRUE;
    }
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features.core)
        .push_next(&mut features.eleven)
        .push_next(&mut features.twelve);
    if choices.barriers == Barriers::Synchronization2 {
        info = info.push_next(&mut second);
    }
    if choices.subgroup.is_some() || full {
        info = info.push_next(&mut sizes);
    }
    if extras.statistics {
        info = info.push_next(&mut features.statistics);
    }
    let extensions: Vec<*const c_char> =
        extensions(instance.0.presents, &adapter.offers, choices, extras).iter().map(|name| name.as_ptr()).collect();
    let info = info.enabled_extension_names(&extensions);
    let raw = vk_call("vkCreateDevice", &opening(adapter), || {
        // SAFETY: `info` and all it points to live through the call; the adapter is this instance's.
        unsafe { instance.0.raw.create_device(adapter.physical, &info, None) }
    })?;
    // SAFETY: the family was named in `info`, with so many queues.
    let queues = [0, count as u32 - 1].map(|index| unsafe { raw.get_device_queue(adapter.queue_family, index) });
    Ok((raw, queues))
}

/// The extensions that a device is opened with.
fn extensions(presents: bool, offers: &Offers, choices: &Choices, extras: &Extras) -> Vec<&'static CStr> {
    let all = [
        (extras.statistics, khr::pipeline_executable_properties::NAME),
        (presents, khr::swapchain::NAME),
        (choices.descriptors == Descriptors::Push, khr::push_descriptor::NAME),
        (choices.barriers == Barriers::Synchronization2, khr::synchronization2::NAME),
        (choices.subgroup.is_some() || offers.full_subgroups, ext::subgroup_size_control::NAME),
        (offers.portability_subset, khr::portability_subset::NAME),
    ];
    all.into_iter().filter(|(needed, _)| *needed).map(|(_, name)| name).chain(offers.clock).collect()
}

/// The names of the extensions that a device is opened with, and of others that its driver offers.
#[cfg(feature = "measure")]
pub(super) fn extension_names(
    instance: &Instance,
    adapter: &Adapter,
    choices: &Choices,
    extras: &Extras,
) -> [Vec<String>; 2] {
    let text = |name: &CStr| name.to_string_lossy().into_owned();
    let used: Vec<String> =
        extensions(instance.0.presents, &adapter.offers, choices, extras).into_iter().map(text).collect();
    // SAFETY: a plain query on a device of this instance.
    let offered = unsafe { instance.0.raw.enumerate_device_extension_properties(adapter.physical) };
    let offered = offered.unwrap_or_default();
    let names = offered.iter().filter_map(|known| known.extension_name_as_c_str().ok().map(text));
    let mut others: Vec<String> = names.filter(|name| !used.contains(name)).collect();
    others.sort();
    [used, others]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_of_a_part_of_vulkan_are_opened_as_such() {
        let (choices, extras) = (Choices::default(), Extras::default());
        let whole = extensions(false, &Offers::default(), &choices, &extras);
        assert!(whole.is_empty());
        let mut offers = Offers::default();
        (offers.portability_subset, offers.full_subgroups) = (true, true);
        let part = extensions(true, &offers, &choices, &extras);
        assert_eq!(part, [khr::swapchain::NAME, ext::subgroup_size_control::NAME, khr::portability_subset::NAME]);
    }
}
