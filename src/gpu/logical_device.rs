//! The logical device: its queue, its memory, its command buffers and its pipeline cache. Buffers, kernels and
//! recordings hold a clone of it.

mod again;
mod clock;
mod create;
mod pipeline_cache;

use std::cell::{Cell, RefCell};
use std::ffi::CString;
use std::fmt::Display;
use std::rc::Rc;
use std::time::Duration;

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::AllocatorCreateDesc;
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::adapter::{Adapter, Limits};
use super::allocator::{Memory, MemoryUse};
use super::call::vk_call;
use super::choices::Choices;
use super::extras::Extras;
use super::faults::{Told, tell};
use super::instance::Instance;
use crate::error::{Error, Result};
use create::{create, opening};
use spares::Spares;
use submission::GRACE;

mod spares;
mod submission;

/// How long a part of a frame should take that is one submission, unless [`LogicalDevice::cut_at`] sets another limit.
const LONGEST: Duration = Duration::from_millis(500);

/// How long a submission may take, unless [`LogicalDevice::wait_at_most`] sets another limit.
const PATIENCE: Duration = Duration::from_secs(600);

/// An opened device with one compute queue, without kernels: see [`super::Device`]. Clones share it; it stays on its
/// thread, because its queue and command pool do.
#[derive(Clone)]
pub struct LogicalDevice(Rc<Inner>);

struct Inner {
    raw: ash::Device,
    debug: Option<ext::debug_utils::Device>,
    push_descriptors: khr::push_descriptor::Device,
    synchronization2: khr::synchronization2::Device,
    /// The queue, and the second one if the choices need it; else the same.
    queues: [vk::Queue; 2],
    pool: vk::CommandPool,
    pipeline_cache: Cell<vk::PipelineCache>,
    adapter: Adapter,
    choices: Choices,
    extras: Extras,
    memory: Memory,
    /// How long a submission may take.
    patience: Cell<Duration>,
    /// How long a part of a frame may take that is one submission.
    longest: Cell<Duration>,
    /// Whether kernels are compiled ahead of the frame that first uses them, where that is any use.
    ahead: Cell<bool>,
    /// Whether the device's clock is read after each frame that is timed.
    aligned: Cell<bool>,
    /// Submissions so far.
    submissions: Cell<u64>,
    /// The fence of a submission that exceeded its limit and may still be running; null where there is none.
    late: Cell<vk::Fence>,
    /// How much longer to wait for that submission; what it uses is leaked if it takes longer still.
    grace: Cell<Duration>,
    /// Whether the next use of the device waits for that submission as long as one may take: the first one does.
    waits_for_late: Cell<bool>,
    /// Whether it has reported work as done that it did not execute: nothing of it is destroyed any more.
    given_up: Cell<bool>,
    /// What submissions have used and others will use again.
    spares: RefCell<Spares>,
    instance: Instance,
}

impl LogicalDevice {
    /// Opens an adapter to use it as chosen and with these extras, or says why that can't be done.
    pub(super) fn open(instance: &Instance, adapter: &Adapter, choices: &Choices, extras: &Extras) -> Result<Self> {
        let doing = opening(adapter);
        // Null hardware serves where it is asked what its compiler makes of pipelines.
        let unusable = adapter.unusable.clone().filter(|_| !adapter.null || !extras.statistics);
        if let Some(why) = unusable.or_else(|| adapter.offers.lack(choices)) {
            return Err(Error::device(doing, why));
        }
        let (raw, queues) = create(instance, adapter, choices, extras)?;
        let debug = instance.0.debug.as_ref().map(|_| ext::debug_utils::Device::new(&instance.0.raw, &raw));
        let mut inner = Inner {
            push_descriptors: khr::push_descriptor::Device::new(&instance.0.raw, &raw),
            synchronization2: khr::synchronization2::Device::new(&instance.0.raw, &raw),
            raw,
            debug,
            queues,
            pool: vk::CommandPool::null(),
            pipeline_cache: Cell::default(),
            adapter: adapter.clone(),
            choices: choices.clone(),
            extras: extras.clone(),
            memory: Memory::default(),
            patience: Cell::new(PATIENCE),
            longest: Cell::new(LONGEST),
            ahead: Cell::default(),
            aligned: Cell::default(),
            submissions: Cell::default(),
            late: Cell::default(),
            grace: Cell::new(GRACE),
            waits_for_late: Cell::new(true),
            given_up: Cell::default(),
            spares: RefCell::default(),
            instance: instance.clone(),
        };

        // Each handle is stored in `inner` as soon as it is created, so that a later failure frees it.
        let description = AllocatorCreateDesc {
            instance: inner.instance.0.raw.clone(),
            device: inner.raw.clone(),
            physical_device: adapter.physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: AllocationSizes::default(),
        };
        inner.memory = Memory::new(&description, &doing)?;
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(adapter.queue_family);
        // SAFETY: the device is alive.
        inner.pool = vk_call("vkCreateCommandPool", &doing, || unsafe { inner.raw.create_command_pool(&pool, None) })?;
        let device = Self(Rc::new(inner));
        device.label(device.raw().handle(), &adapter.name);
        device.label(device.0.pool, "commands");
        device.label(queues[1], "second compute queue");
        // The only one, where there are not two.
        device.label(queues[0], "compute queue");
        device.renew_pipeline_cache(&[])?;
        Ok(device)
    }

    /// The choices by which it is used.
    pub fn choices(&self) -> &Choices {
        &self.0.choices
    }

    /// Bytes of device memory allocated now and at the peak.
    pub fn memory(&self) -> MemoryUse {
        self.0.memory.used()
    }

    /// Makes the memory allocated now the peak.
    pub fn forget_peak(&self) {
        self.0.memory.forget_peak();
    }

    /// The names of all allocations.
    pub fn allocations(&self) -> Vec<String> {
        self.0.memory.names()
    }

    /// Sets how long a submission may take before the device counts as hung; the default is ten minutes.
    pub fn wait_at_most(&self, patience: Duration) {
        self.0.patience.set(patience);
        self.0.waits_for_late.set(true);
    }

    /// Sets how long a submission should take: a frame is cut into several, as its steps' last times say, where the
    /// device is no processor; the default is half a second, since the driver of a display resets a device after two.
    pub fn cut_at(&self, longest: Duration) {
        self.0.longest.set(longest);
    }

    /// The adapter.
    pub fn adapter(&self) -> &Adapter {
        &self.0.adapter
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        &self.0.adapter.name
    }

    /// The driver's name and version.
    pub fn driver(&self) -> &str {
        &self.0.adapter.driver
    }

    /// The adapter's limits.
    pub fn limits(&self) -> &Limits {
        &self.0.adapter.limits
    }

    /// Takes the validation messages that have come since the last call.
    pub fn take_messages(&self) -> Vec<String> {
        self.0.instance.take_messages()
    }

    pub(super) fn raw(&self) -> &ash::Device {
        &self.0.raw
    }

    #[cfg(feature = "window")]
    pub(super) fn queue(&self) -> vk::Queue {
        self.0.queues[0]
    }

    /// The functions of `VK_KHR_push_descriptor`, if the choices need it.
    pub(super) fn push_descriptors(&self) -> &khr::push_descriptor::Device {
        &self.0.push_descriptors
    }

    /// The functions of `VK_KHR_synchronization2`, if the choices need it.
    pub(super) fn synchronization2(&self) -> &khr::synchronization2::Device {
        &self.0.synchronization2
    }

    /// The functions for debug labels, where the loader offers them.
    pub(super) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.0.debug.as_ref()
    }

    /// The device's memory.
    pub(super) fn heap(&self) -> &Memory {
        &self.0.memory
    }

    /// Gives a handle the name that tools and validation messages show, where the loader offers names.
    pub(super) fn label<T: vk::Handle>(&self, handle: T, name: impl Display) {
        let Some(debug) = &self.0.debug else { return };
        let text = name.to_string();
        if let Ok(name) = CString::new(text.as_str()) {
            tell(|| Told::Name(format!("{:?}", T::TYPE), text));
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
            // Nothing depends on a name, so a failure to set it is ignored.
            let _ = vk_call("vkSetDebugUtilsObjectNameEXT", "naming", || {
                // SAFETY: the handle is alive.
                unsafe { debug.set_debug_utils_object_name(&info) }
            });
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        let allocator = self.memory.take();
        if !self.finished() {
            // What a hung device may still use lives until the process ends; null hardware crashes when it is
            // destroyed.
            std::mem::forget((allocator, self.instance.clone()));
            return;
        }
        // SAFETY: buffers and kernels hold a clone of the device, so none is left; the allocator goes before it.
        unsafe {
            let _ = vk_call("vkDeviceWaitIdle", "closing the device", || self.raw.device_wait_idle());
            drop(allocator);
            self.spares.get_mut().destroy(&self.raw);
            self.raw.destroy_pipeline_cache(self.pipeline_cache.get(), None);
            self.raw.destroy_command_pool(self.pool, None);
            self.raw.destroy_device(None);
        }
    }
}
