//! The Vulkan instance, its validation messages, and the adapters it offers.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

use ash::{ext, vk};

use super::faults::{altered, tried};
use crate::error::{Error, Result};

/// A loaded Vulkan library. Clones share it.
#[derive(Clone)]
pub struct Instance(pub(super) Arc<Inner>);

pub(super) struct Inner {
    pub(super) raw: ash::Instance,
    pub(super) debug: Option<ext::debug_utils::Instance>,
    messenger: vk::DebugUtilsMessengerEXT,
    messages: Box<Mutex<Vec<String>>>,
    _entry: ash::Entry,
}

/// What a device can do, as far as milkglass cares.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Largest range of one storage-buffer binding, bytes.
    pub binding_bytes: u64,
    /// Alignment of a bound range's offset, bytes.
    pub offset_alignment: u64,
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
    /// Nanoseconds a timestamp tick; 0 where the queue has no timestamps.
    pub timestamp_period: f32,
    /// The bits of a timestamp that count; above them it wraps round.
    pub timestamp_mask: u64,
    /// Whether 32-bit float rounding to nearest can be requested.
    pub round_to_nearest: bool,
}

/// A Vulkan device that could be opened.
#[derive(Clone, Debug, Default)]
pub struct Adapter {
    /// The device's name.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// The Vulkan version, `1.3.230`.
    pub version: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    /// Its limits.
    pub limits: Limits,
    /// Why it can't be used, if it can't.
    pub unusable: Option<String>,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) queue_family: u32,
}

impl Adapter {
    /// The usable adapter that promises most: discrete, integrated, virtual, then anything.
    pub fn best(adapters: &[Self]) -> Option<&Self> {
        let rank = |adapter: &&Self| match adapter.kind {
            "discrete" => 0,
            "integrated" => 1,
            "virtual" => 2,
            _ => 3,
        };
        adapters.iter().filter(|adapter| adapter.unusable.is_none()).min_by_key(rank)
    }
}

unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `user` is the boxed list of `Inner`, which outlives the messenger; the layer passes valid strings.
    unsafe {
        let list = &*user.cast::<Mutex<Vec<String>>>();
        let text = (*data).p_message;
        if !text.is_null()
            && let Ok(mut list) = list.lock()
        {
            list.push(format!("{severity:?}: {}", CStr::from_ptr(text).to_string_lossy()));
        }
    }
    vk::FALSE
}

impl Instance {
    /// Loads Vulkan; with `validation`, the Khronos layer with synchronization validation, whose messages are kept.
    pub fn open(validation: bool) -> Result<Self> {
        let doing = "loading Vulkan";
        // SAFETY: the loader is the system's; nothing else is loaded in its name.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| {
            Error::device(
                doing,
                format!(
                    "no Vulkan loader; install one (Debian: libvulkan1, mesa-vulkan-drivers), or use --device cpu: {e}"
                ),
            )
        })?;
        let application =
            vk::ApplicationInfo::default().application_name(c"milkglass").api_version(vk::API_VERSION_1_2);
        let mut extensions = Vec::new();
        let mut layers = Vec::new();
        // Loaders fail here where no driver can be loaded; what comes next says so in better words.
        let offered = tried("vkEnumerateInstanceExtensionProperties", doing, || {
            // SAFETY: a plain query on a loaded entry.
            unsafe { entry.enumerate_instance_extension_properties(None) }
        })
        .unwrap_or_default();
        let labels =
            offered.iter().any(|e| e.extension_name_as_c_str().is_ok_and(|name| name == ext::debug_utils::NAME));
        if labels || validation {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validation {
            layers.push(c"VK_LAYER_KHRONOS_validation".as_ptr());
            extensions.push(ext::validation_features::NAME.as_ptr());
            info = info.push_next(&mut features);
        }
        let info = info.enabled_extension_names(&extensions).enabled_layer_names(&layers);
        let raw = tried("vkCreateInstance", "starting Vulkan", || {
            // SAFETY: `info` and all it points to live through the call.
            unsafe { entry.create_instance(&info, None) }
        })?;
        let debug = (labels || validation).then(|| ext::debug_utils::Instance::new(&entry, &raw));
        let mut inner = Inner {
            raw,
            debug,
            messenger: vk::DebugUtilsMessengerEXT::null(),
            messages: Box::default(),
            _entry: entry,
        };
        if validation && let Some(debug) = &inner.debug {
            use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Kind};
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(Severity::WARNING | Severity::ERROR)
                .message_type(Kind::VALIDATION | Kind::GENERAL)
                .pfn_user_callback(Some(on_message))
                .user_data(std::ptr::from_ref(&*inner.messages).cast_mut().cast());
            inner.messenger = tried("vkCreateDebugUtilsMessengerEXT", "listening to the validation layer", || {
                // SAFETY: the callback's data lives in the box of `inner`, freed after the messenger.
                unsafe { debug.create_debug_utils_messenger(&info, None) }
            })?;
        }
        Ok(Self(Arc::new(inner)))
    }

    /// Takes the validation messages that have come since the last call.
    pub fn take_messages(&self) -> Vec<String> {
        self.0.messages.lock().map(|mut list| std::mem::take(&mut *list)).unwrap_or_default()
    }

    /// Every adapter, in the loader's order.
    pub fn adapters(&self) -> Result<Vec<Adapter>> {
        let list = tried("vkEnumeratePhysicalDevices", "listing Vulkan devices", || {
            // SAFETY: the instance is alive.
            unsafe { self.0.raw.enumerate_physical_devices() }
        })?;
        Ok(list.into_iter().map(|physical| altered(self.adapter(physical))).collect())
    }

    fn adapter(&self, physical: vk::PhysicalDevice) -> Adapter {
        let raw = &self.0.raw;

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
            raw.get_physical_device_properties2(physical, &mut properties);
            raw.get_physical_device_features2(physical, &mut features);
            (
                raw.get_physical_device_queue_family_properties(physical),
                raw.get_physical_device_memory_properties(physical),
            )
        };
        let own = |heap: &&vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        let base = properties.properties;
        // What a driver on the CPU says of its heap is a number it made up: its memory is the host's.
        let heap_bytes = match base.device_type {
            vk::PhysicalDeviceType::CPU => u64::MAX,
            _ => memory.memory_heaps_as_slice().iter().filter(own).map(|heap| heap.size).max().unwrap_or(0),
        };
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
        let version = base.api_version;
        let (major, minor, patch) =
            (vk::api_version_major(version), vk::api_version_minor(version), vk::api_version_patch(version));
        let unusable = if (major, minor) < (1, 2) {
            Some(format!("offers Vulkan {major}.{minor}, 1.2 is needed"))
        } else if features12.scalar_block_layout == vk::FALSE {
            Some("lacks the feature scalarBlockLayout".to_string())
        } else if family.is_none() {
            Some("has no compute queue".to_string())
        } else {
            None
        };
        let bits = family.map_or(0, |f| queues[f].timestamp_valid_bits);
        let timed = bits > 0;
        Adapter {
            name: text(&base.device_name),
            driver: format!("{} {}", text(&more.driver_name), text(&more.driver_info)).trim().to_string(),
            version: format!("{major}.{minor}.{patch}"),
            kind: match base.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
                vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
                vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
                vk::PhysicalDeviceType::CPU => "cpu",
                _ => "other",
            },
            limits: Limits {
                binding_bytes: base.limits.max_storage_buffer_range.into(),
                offset_alignment: base.limits.min_storage_buffer_offset_alignment,
                allocation_bytes: third.max_memory_allocation_size,
                storage_buffers: base
                    .limits
                    .max_per_stage_descriptor_storage_buffers
                    .min(base.limits.max_descriptor_set_storage_buffers),
                push_bytes: base.limits.max_push_constants_size,
                group_invocations: base.limits.max_compute_work_group_invocations,
                groups: [0, 1].map(|k| base.limits.max_compute_work_group_count[k]),
                heap_bytes,
                subgroup_size: subgroup.subgroup_size,
                timestamp_mask: u64::MAX >> (64 - bits.clamp(1, 64)),
                timestamp_period: if timed { base.limits.timestamp_period } else { 0.0 },
                round_to_nearest: more.shader_rounding_mode_rte_float32 == vk::TRUE,
            },
            unusable,
            physical,
            queue_family: u32::try_from(family.unwrap_or(0)).unwrap_or(0),
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: devices hold a clone of the instance, so none is left; the messenger goes before its instance.
        unsafe {
            if let Some(debug) = &self.debug
                && self.messenger != vk::DebugUtilsMessengerEXT::null()
            {
                debug.destroy_debug_utils_messenger(self.messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}
