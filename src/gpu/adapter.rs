//! The adapters of a machine: what each can do, and whether milkglass can run on it.

use std::ffi::CStr;

use ash::vk;

use super::offers::Offers;
use crate::error::{Error, Result};

/// AMD's number among vendors.
const AMD: u32 = 0x1002;

/// What a device can do, as far as milkglass cares.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Largest range of one storage-buffer binding, bytes.
    pub binding_bytes: u64,
    /// Alignment of a bound range's offset, bytes.
    pub offset_alignment: u64,
    /// Alignment of the offset of bound constants, bytes.
    pub uniform_alignment: u64,
    /// Largest single allocation, bytes.
    pub allocation_bytes: u64,
    /// Storage buffers one kernel can bind.
    pub storage_buffers: u32,
    /// Push constants, bytes.
    pub push_bytes: u32,
    /// Invocations in a group.
    pub group_invocations: u32,
    /// Groups in the first two dimensions of a dispatch.
    pub groups: [u32; 2],
    /// Largest heap of the device's own memory, bytes; no limit where that is the host's.
    pub heap_bytes: u64,
    /// Invocations that run in lockstep.
    pub subgroup_size: u32,
    /// Nanoseconds per timestamp tick; 0 where the queue has no timestamps.
    pub timestamp_period: f32,
    /// The bits of a timestamp that are valid; above them it wraps around.
    pub timestamp_mask: u64,
    /// Whether 32-bit float rounding to nearest can be requested.
    pub round_to_nearest: bool,
}

impl Limits {
    /// Those that Vulkan 1.0 tells, for a queue with so many bits in a timestamp.
    fn core(limits: &vk::PhysicalDeviceLimits, timestamp_bits: u32) -> Self {
        Self {
            binding_bytes: limits.max_storage_buffer_range.into(),
            offset_alignment: limits.min_storage_buffer_offset_alignment,
            uniform_alignment: limits.min_uniform_buffer_offset_alignment,
            storage_buffers: limits
                .max_per_stage_descriptor_storage_buffers
                .min(limits.max_descriptor_set_storage_buffers),
            push_bytes: limits.max_push_constants_size,
            group_invocations: limits.max_compute_work_group_invocations,
            groups: [0, 1].map(|k| limits.max_compute_work_group_count[k]),
            timestamp_mask: u64::MAX >> (64 - timestamp_bits.clamp(1, 64)),
            timestamp_period: if timestamp_bits > 0 { limits.timestamp_period } else { 0.0 },
            ..Self::default()
        }
    }
}

/// The numbers by which Vulkan names a device and its driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ids {
    /// The vendor.
    pub vendor: u32,
    /// The device.
    pub device: u32,
    /// The driver: `VkDriverId`.
    pub driver: i32,
    /// The driver's version, in an encoding of its own.
    pub driver_version: u32,
}

/// A Vulkan device that could be opened.
#[derive(Clone, Debug, Default)]
pub struct Adapter {
    /// Its number in the loader's order: what `milkglass devices` lists and `--device` takes.
    pub number: usize,
    /// The device's name, with ` #` and its number where several have the same.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// The Vulkan version, `1.3.230`.
    pub version: String,
    /// The vendor's and the device's number, the driver's number and its version as Vulkan encodes them.
    pub ids: Ids,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    /// Its limits.
    pub limits: Limits,
    /// What it offers beyond what it has to.
    pub offers: Offers,
    /// Whether it is RADV's null hardware, which compiles kernels and executes none.
    pub null: bool,
    /// Why it can't be used, if it can't.
    pub unusable: Option<String>,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) queue_family: u32,
}

impl Adapter {
    /// The usable adapter that promises the most: discrete, integrated, virtual, then any other.
    pub fn best(adapters: &[Self]) -> Option<&Self> {
        let rank = |adapter: &&Self| match adapter.kind {
            "discrete" => 0,
            "integrated" => 1,
            "virtual" => 2,
            _ => 3,
        };
        adapters.iter().filter(|adapter| adapter.unusable.is_none()).min_by_key(rank)
    }

    /// The adapter with this number or name, or the only one whose name contains this text.
    pub fn find<'a>(adapters: &'a [Self], wish: &str) -> Result<&'a Self> {
        let low = wish.to_lowercase();
        let named = |fits: &dyn Fn(&str) -> bool| {
            let fitting = |adapter: &&Self| !low.is_empty() && fits(&adapter.name.to_lowercase());
            adapters.iter().filter(fitting).collect::<Vec<_>>()
        };
        let whole = named(&|name| name == low);
        let found = if whole.is_empty() { named(&|name| name.contains(&low)) } else { whole };
        let by_number = wish.parse::<usize>().ok().and_then(|index| adapters.get(index));
        let names: Vec<_> = adapters.iter().enumerate().map(|(i, a)| format!("{i} ({})", a.name)).collect();
        let known = names.join(", ");
        let what = match (by_number, found.as_slice()) {
            (Some(adapter), _) => return Ok(adapter),
            (None, &[adapter]) => return Ok(adapter),
            (None, []) if names.is_empty() => "no Vulkan device is installed; there is only cpu".into(),
            (None, []) => format!("there is none; there are cpu, {known}"),
            (None, several) => format!("{} devices have that in their names, give a number: {known}", several.len()),
        };
        Err(Error::device(format!("looking for device {wish:?}"), what))
    }

    /// Whether it is Mesa's software device. Kernels are compiled there when they are first dispatched and kept on disk
    /// for all devices; a subgroup is a vector of the processor.
    pub(super) fn is_llvmpipe(&self) -> bool {
        self.ids.driver == vk::DriverId::MESA_LLVMPIPE.as_raw()
    }

    /// The subgroup size for kernels that shuffle, where the driver's own choice is not the best: AMD's drivers take
    /// 64 of 32 to 64.
    pub(super) fn narrower(&self) -> Option<u32> {
        let both = self.offers.subgroups == Some([32, 64]) && self.limits.subgroup_size == 64;
        (both && self.ids.vendor == AMD).then_some(32)
    }

    /// Numbers all adapters, and adds the number to names that several have, `llvmpipe #0` and `llvmpipe #1`: results
    /// go by names.
    pub(super) fn tell_apart(adapters: &mut [Self]) {
        let names: Vec<String> = adapters.iter().map(|adapter| adapter.name.clone()).collect();
        for (index, adapter) in adapters.iter_mut().enumerate() {
            adapter.number = index;
            if names.iter().filter(|name| **name == names[index]).count() > 1 {
                adapter.name += &format!(" #{index}");
            }
        }
    }

    /// What an instance says of one of its physical devices.
    pub(super) fn query(entry: &ash::Entry, instance: &ash::Instance, physical: vk::PhysicalDevice) -> Self {
        // Properties and features, each with its 1.2 extension chain.
        let mut more = vk::PhysicalDeviceVulkan12Properties::default();
        let mut third = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut more)
            .push_next(&mut third)
            .push_next(&mut subgroup);
        let mut features12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut features12);
        // SAFETY: the chains live through the calls; a device of version 1.2 or newer fills them.
        let (queues, memory) = unsafe {
            instance.get_physical_device_properties2(physical, &mut properties);
            instance.get_physical_device_features2(physical, &mut features);
            (
                instance.get_physical_device_queue_family_properties(physical),
                instance.get_physical_device_memory_properties(physical),
            )
        };
        let base = properties.properties;
        let text = |bytes: &[std::ffi::c_char]| {
            // SAFETY: the driver terminates these fixed arrays with a zero.
            unsafe { CStr::from_ptr(bytes.as_ptr()) }.to_string_lossy().into_owned()
        };

        // A queue for compute, preferably with timestamps.
        let compute = |q: &vk::QueueFamilyProperties| q.queue_flags.contains(vk::QueueFlags::COMPUTE);
        let family = queues
            .iter()
            .position(|q| compute(q) && q.timestamp_valid_bits > 0)
            .or_else(|| queues.iter().position(compute));
        let [major, minor, patch] =
            [vk::api_version_major, vk::api_version_minor, vk::api_version_patch].map(|part| part(base.api_version));
        let null = more.driver_id == vk::DriverId::MESA_RADV && text(&base.device_name).starts_with("Null hardware");
        let packed = features12.scalar_block_layout == vk::TRUE;
        let bits = family.map_or(0, |f| queues[f].timestamp_valid_bits);
        let queue_family = u32::try_from(family.unwrap_or(0)).unwrap_or(0);
        Adapter {
            number: 0,
            null,
            name: text(&base.device_name),
            driver: format!("{} {}", text(&more.driver_name), text(&more.driver_info)).trim().to_string(),
            version: format!("{major}.{minor}.{patch}"),
            ids: Ids {
                vendor: base.vendor_id,
                device: base.device_id,
                driver: more.driver_id.as_raw(),
                driver_version: base.driver_version,
            },
            kind: kind(base.device_type),
            limits: Limits {
                allocation_bytes: third.max_memory_allocation_size,
                heap_bytes: heap_bytes(base.device_type, &memory),
                subgroup_size: subgroup.subgroup_size,
                round_to_nearest: more.shader_rounding_mode_rte_float32 == vk::TRUE,
                ..Limits::core(&base.limits, bits)
            },
            offers: Offers::query(entry, instance, physical, queue_family),
            unusable: lack(null, [major, minor], packed, family.is_some()),
            physical,
            queue_family,
        }
    }
}

/// Why a device can't be used, if it can't.
fn lack(null: bool, [major, minor]: [u32; 2], packed: bool, computes: bool) -> Option<String> {
    if null {
        Some("is null hardware, which compiles kernels and executes none (RADV_FORCE_FAMILY is set)".to_string())
    } else if (major, minor) < (1, 2) {
        Some(format!("offers Vulkan {major}.{minor}, 1.2 is needed"))
    } else if !packed {
        Some("lacks the feature scalarBlockLayout".to_string())
    } else if !computes {
        Some("has no compute queue".to_string())
    } else {
        None
    }
}

/// Bytes of the largest heap of a device's own memory.
fn heap_bytes(device_type: vk::PhysicalDeviceType, memory: &vk::PhysicalDeviceMemoryProperties) -> u64 {
    let own = |heap: &&vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
    // The memory of a driver on the CPU is the host's; the size of its heap is arbitrary.
    match device_type {
        vk::PhysicalDeviceType::CPU => u64::MAX,
        _ => memory.memory_heaps_as_slice().iter().filter(own).map(|heap| heap.size).max().unwrap_or(0),
    }
}

/// The word for a type of device.
fn kind(device_type: vk::PhysicalDeviceType) -> &'static str {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
        vk::PhysicalDeviceType::CPU => "cpu",
        _ => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::Adapter;

    #[test]
    fn only_gpus_of_amd_that_offer_both_sizes_get_the_narrower_subgroups() {
        let adapter = |vendor: u32, subgroups: [u32; 2], size: u32| {
            let mut adapter = Adapter::default();
            (adapter.ids.vendor, adapter.offers.subgroups, adapter.limits.subgroup_size) =
                (vendor, Some(subgroups), size);
            adapter.narrower()
        };
        assert_eq!(adapter(super::AMD, [32, 64], 64), Some(32));
        for (vendor, offered, size) in [(super::AMD, [64, 64], 64), (super::AMD, [32, 64], 32), (0x10de, [32, 32], 32)]
        {
            assert_eq!(adapter(vendor, offered, size), None);
        }
    }

    #[test]
    fn devices_go_by_number_and_by_as_much_of_the_name_as_tells_them_apart() {
        let named = |name: &str| Adapter { name: name.into(), ..Adapter::default() };
        let adapters = ["GeForce RTX 4090", "GeForce RTX 4090 Ti", "llvmpipe", "llvmpipe"].map(named);
        let at = |wish: &str| Adapter::find(&adapters, wish).map(|found| found as *const Adapter as usize);
        let place = |k: usize| &raw const adapters[k] as usize;
        for (wish, k) in [("0", 0), ("3", 3), ("ti", 1), ("geforce rtx 4090", 0), ("4090 TI", 1)] {
            assert_eq!(at(wish).unwrap(), place(k), "{wish}");
        }
        for (wish, words) in [("geforce", "2 devices"), ("llvmpipe", "give a number"), ("7", "there is none")] {
            let error = at(wish).unwrap_err();
            assert!(error.to_string().contains(words) && error.exit_code() == 3, "{wish}: {error}");
            assert!(error.to_string().contains("2 (llvmpipe)"), "{error}");
        }
        let mut apart = adapters.clone();
        Adapter::tell_apart(&mut apart);
        let names: Vec<&str> = apart.iter().map(|adapter| adapter.name.as_str()).collect();
        assert_eq!(names, ["GeForce RTX 4090", "GeForce RTX 4090 Ti", "llvmpipe #2", "llvmpipe #3"]);
        assert!(apart.iter().enumerate().all(|(k, adapter)| adapter.number == k));
        assert!(
            at("").is_err()
                && Adapter::find(&[], "x").unwrap_err().to_string().contains("no Vulkan device is installed")
        );
    }
}
