//! The logical device: its queue, its memory, its command buffers and its pipeline cache. Buffers, kernels and
//! recordings hold a clone of it.

mod again;

use std::cell::Cell;
use std::ffi::CString;
use std::rc::Rc;
use std::time::Duration;

use ash::{ext, vk};
use gpu_allocator::vulkan::AllocatorCreateDesc;
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::adapter::{Adapter, Limits};
use super::allocator::{Memory, MemoryUse};
use super::call::vk_call;
use super::extras::Extras;
use super::instance::Instance;
use crate::error::{Error, Result};

/// How long a submission may take, unless [`LogicalDevice::wait_at_most`] sets another limit.
const PATIENCE: Duration = Duration::from_secs(600);
/// How much longer to wait for a submission that exceeded its limit, before what it uses is freed.
const GRACE: Duration = Duration::from_secs(1);

/// An opened device with one compute queue, without kernels: see [`super::Device`]. Clones share it; it stays on its
/// thread, because its queue and command pool do.
#[derive(Clone)]
pub struct LogicalDevice(Rc<Inner>);

struct Inner {
    raw: ash::Device,
    debug: Option<ext::debug_utils::Device>,
    queue: vk::Queue,
    pool: vk::CommandPool,
    pipeline_cache: vk::PipelineCache,
    adapter: Adapter,
    extras: Extras,
    memory: Memory,
    /// How long a submission may take.
    patience: Cell<Duration>,
    /// Submissions so far.
    submissions: Cell<u64>,
    /// The fence of a submission that exceeded its limit and may still be running; null where there is none.
    late: Cell<vk::Fence>,
    /// How much longer to wait for that submission; what it uses is leaked if it takes longer still.
    grace: Cell<Duration>,
    instance: Instance,
}

impl LogicalDevice {
    /// Opens an adapter, or says why it can't be used.
    pub(super) fn open(instance: &Instance, adapter: &Adapter, extras: &Extras) -> Result<Self> {
        let doing = format!("opening {}", adapter.name);
        if let Some(why) = &adapter.unusable {
            return Err(Error::device(doing, why));
        }
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(adapter.queue_family)
            .queue_priorities(&priorities)];
        let (mut features, extensions) = (extras.features(), extras.extensions());
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features.core)
            .push_next(&mut features.eleven)
            .push_next(&mut features.twelve);
        if extras.statistics {
            info = info.push_next(&mut features.statistics);
        }
        let raw = vk_call("vkCreateDevice", &doing, || {
            // SAFETY: `info` and all it points to live through the call; the adapter is this instance's.
            unsafe { instance.0.raw.create_device(adapter.physical, &info, None) }
        })?;
        // SAFETY: the family was named in `info`, with one queue.
        let queue = unsafe { raw.get_device_queue(adapter.queue_family, 0) };
        let debug = instance.0.debug.as_ref().map(|_| ext::debug_utils::Device::new(&instance.0.raw, &raw));
        let mut inner = Inner {
            raw,
            debug,
            queue,
            pool: vk::CommandPool::null(),
            pipeline_cache: vk::PipelineCache::null(),
            adapter: adapter.clone(),
            extras: extras.clone(),
            memory: Memory::default(),
            patience: Cell::new(PATIENCE),
            submissions: Cell::default(),
            late: Cell::default(),
            grace: Cell::new(GRACE),
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
        let cache = vk::PipelineCacheCreateInfo::default();
        // SAFETY: the device is alive.
        unsafe {
            inner.pool = vk_call("vkCreateCommandPool", &doing, || inner.raw.create_command_pool(&pool, None))?;
            inner.pipeline_cache =
                vk_call("vkCreatePipelineCache", &doing, || inner.raw.create_pipeline_cache(&cache, None))?;
        }
        Ok(Self(Rc::new(inner)))
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

    pub(super) fn pipeline_cache(&self) -> vk::PipelineCache {
        self.0.pipeline_cache
    }

    /// The functions for debug labels, where the loader offers them.
    pub(super) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.0.debug.as_ref()
    }

    /// The device's memory.
    pub(super) fn heap(&self) -> &Memory {
        &self.0.memory
    }

    /// Submits one recorded command buffer and waits for it.
    pub(super) fn submit(&self, commands: vk::CommandBuffer, doing: &str) -> Result<()> {
        let (raw, buffers) = (&self.0.raw, [commands]);
        if !self.finished() {
            return Err(Error::device(doing, "the device is still busy with what it did not finish in time"));
        }
        let info = [vk::SubmitInfo::default().command_buffers(&buffers)];
        let patience = nanoseconds(self.0.patience.get());
        self.0.submissions.set(self.0.submissions.get() + 1);
        // SAFETY: the command buffer is complete and of this device; the fence is destroyed once it is not in use.
        unsafe {
            let fence = vk_call("vkCreateFence", doing, || raw.create_fence(&vk::FenceCreateInfo::default(), None))?;
            let submitted = vk_call("vkQueueSubmit", doing, || raw.queue_submit(self.0.queue, &info, fence));
            let running = submitted.is_ok();
            let done = submitted
                .and_then(|()| vk_call("vkWaitForFences", doing, || raw.wait_for_fences(&[fence], true, patience)));
            if running && done.is_err() {
                self.0.late.set(fence);
            } else {
                raw.destroy_fence(fence, None);
            }
            done
        }
    }

    /// Whether nothing runs on the device, so that what it used may be freed. After a wait that failed, a submission
    /// may still run: then this waits once more, for [`GRACE`], and what the submission uses is leaked if it takes
    /// longer.
    pub(super) fn finished(&self) -> bool {
        self.0.finished()
    }

    /// A command buffer ready to record.
    pub(super) fn begin(&self, doing: &str) -> Result<vk::CommandBuffer> {
        let raw = &self.0.raw;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.0.pool).command_buffer_count(1);
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is this device's and used by one thread at a time.
        unsafe {
            let commands = vk_call("vkAllocateCommandBuffers", doing, || raw.allocate_command_buffers(&info))?[0];
            let begun = vk_call("vkBeginCommandBuffer", doing, || raw.begin_command_buffer(commands, &once));
            begun.inspect_err(|_| self.discard(commands)).map(|()| commands)
        }
    }

    /// Frees a command buffer, unless it may still be running.
    pub(super) fn discard(&self, commands: vk::CommandBuffer) {
        if self.finished() {
            // SAFETY: it is of this device's pool, and nothing is running.
            unsafe { self.0.raw.free_command_buffers(self.0.pool, &[commands]) };
        }
    }

    /// Gives a handle the name that tools and validation messages show.
    pub(super) fn label<T: vk::Handle>(&self, handle: T, name: &str) {
        if let (Some(debug), Ok(name)) = (&self.0.debug, CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
            // Nothing depends on a name, so a failure to set it is ignored.
            let _ = vk_call("vkSetDebugUtilsObjectNameEXT", "naming", || {
                // SAFETY: the handle is alive.
                unsafe { debug.set_debug_utils_object_name(&info) }
            });
        }
    }
}

/// As Vulkan counts time.
fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Inner {
    /// See [`LogicalDevice::finished`].
    fn finished(&self) -> bool {
        let fence = self.late.get();
        if fence == vk::Fence::null() {
            return true;
        }
        // SAFETY: the fence is alive; it is destroyed once it is signalled or its device lost.
        unsafe {
            let wait = self.raw.wait_for_fences(&[fence], true, nanoseconds(self.grace.take()));
            if wait == Err(vk::Result::TIMEOUT) {
                return false;
            }
            self.raw.destroy_fence(fence, None);
        }
        self.late.set(vk::Fence::null());
        self.grace.set(GRACE);
        true
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        let allocator = self.memory.take();
        if !self.finished() {
            // What a hung device may still use lives until the process ends.
            std::mem::forget((allocator, self.instance.clone()));
            return;
        }
        // SAFETY: buffers and kernels hold a clone of the device, so none is left; the allocator goes before it.
        unsafe {
            let _ = vk_call("vkDeviceWaitIdle", "closing the device", || self.raw.device_wait_idle());
            drop(allocator);
            self.raw.destroy_pipeline_cache(self.pipeline_cache, None);
            self.raw.destroy_command_pool(self.pool, None);
            self.raw.destroy_device(None);
        }
    }
}
