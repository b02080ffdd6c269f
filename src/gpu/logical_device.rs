//! The logical device: its queue, its memory, its command buffers and its pipeline cache. Buffers, kernels and
//! recordings hold a clone of it.

use std::cell::Cell;
use std::ffi::CString;
use std::rc::Rc;
use std::time::Duration;

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::AllocatorCreateDesc;
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::adapter::{Adapter, Limits};
use super::allocator::{Memory, MemoryUse};
use super::call::vk_call;
use super::choices::{Barriers, Cache, Choices, Descriptors};
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
    push_descriptors: khr::push_descriptor::Device,
    synchronization2: khr::synchronization2::Device,
    queue: vk::Queue,
    pool: vk::CommandPool,
    pipeline_cache: Cell<vk::PipelineCache>,
    adapter: Adapter,
    choices: Choices,
    memory: Memory,
    /// How long a submission may take.
    patience: Cell<Duration>,
    /// The fence of a submission that exceeded its limit and may still be running; null where there is none.
    late: Cell<vk::Fence>,
    /// How much longer to wait for that submission; what it uses is leaked if it takes longer still.
    grace: Cell<Duration>,
    instance: Instance,
}

impl LogicalDevice {
    /// Opens an adapter to use it as chosen, or says why that can't be done.
    pub(super) fn open(instance: &Instance, adapter: &Adapter, choices: &Choices) -> Result<Self> {
        let doing = format!("opening {}", adapter.name);
        if let Some(why) = adapter.unusable.clone().or_else(|| adapter.offers.lack(choices)) {
            return Err(Error::device(doing, why));
        }
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(adapter.queue_family)
            .queue_priorities(&priorities)];

        // What the choices need, and nothing else.
        let mut extensions = Vec::new();
        let mut features = vk::PhysicalDeviceVulkan12Features::default().scalar_block_layout(true);
        let mut second = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
        let mut sizes = vk::PhysicalDeviceSubgroupSizeControlFeatures::default().subgroup_size_control(true);
        if choices.descriptors == Descriptors::Frame {
            features = features
                .descriptor_binding_partially_bound(true)
                .descriptor_binding_storage_buffer_update_after_bind(true);
        }
        let mut info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
        if choices.descriptors == Descriptors::Push {
            extensions.push(khr::push_descriptor::NAME.as_ptr());
        }
        if choices.barriers == Barriers::Synchronization2 {
            extensions.push(khr::synchronization2::NAME.as_ptr());
            info = info.push_next(&mut second);
        }
        if choices.subgroup.is_some() {
            extensions.push(ext::subgroup_size_control::NAME.as_ptr());
            info = info.push_next(&mut sizes);
        }
        let info = info.enabled_extension_names(&extensions);
        let raw = vk_call("vkCreateDevice", &doing, || {
            // SAFETY: `info` and all it points to live through the call; the adapter is this instance's.
            unsafe { instance.0.raw.create_device(adapter.physical, &info, None) }
        })?;
        // SAFETY: the family was named in `info`, with one queue.
        let queue = unsafe { raw.get_device_queue(adapter.queue_family, 0) };
        let debug = instance.0.debug.as_ref().map(|_| ext::debug_utils::Device::new(&instance.0.raw, &raw));
        let mut inner = Inner {
            push_descriptors: khr::push_descriptor::Device::new(&instance.0.raw, &raw),
            synchronization2: khr::synchronization2::Device::new(&instance.0.raw, &raw),
            raw,
            debug,
            queue,
            pool: vk::CommandPool::null(),
            pipeline_cache: Cell::default(),
            adapter: adapter.clone(),
            choices: choices.clone(),
            memory: Memory::default(),
            patience: Cell::new(PATIENCE),
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
        // SAFETY: the device is alive.
        inner.pool = vk_call("vkCreateCommandPool", &doing, || unsafe { inner.raw.create_command_pool(&pool, None) })?;
        let device = Self(Rc::new(inner));
        device.renew_pipeline_cache(&[])?;
        Ok(device)
    }

    /// Replaces the pipeline cache by one with this content, which a driver ignores if it is not its own.
    pub(crate) fn renew_pipeline_cache(&self, content: &[u8]) -> Result<()> {
        if self.0.choices.cache == Cache::Without {
            return Ok(());
        }
        let info = vk::PipelineCacheCreateInfo::default().initial_data(content);
        // SAFETY: the device is alive; no pipeline is being made from the old cache.
        let new = vk_call("vkCreatePipelineCache", "making a pipeline cache", || unsafe {
            self.0.raw.create_pipeline_cache(&info, None)
        })?;
        let old = self.0.pipeline_cache.replace(new);
        // SAFETY: pipelines do not need the cache that they were made from.
        unsafe { self.0.raw.destroy_pipeline_cache(old, None) };
        Ok(())
    }

    /// The content of the pipeline cache.
    #[cfg(feature = "measure")]
    pub(crate) fn pipeline_cache_content(&self) -> Result<Vec<u8>> {
        // SAFETY: the cache is alive, or there is none.
        vk_call("vkGetPipelineCacheData", "reading the pipeline cache", || unsafe {
            match self.pipeline_cache() {
                cache if cache == vk::PipelineCache::null() => Ok(Vec::new()),
                cache => self.0.raw.get_pipeline_cache_data(cache),
            }
        })
    }

    /// How it is used.
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
        self.0.pipeline_cache.get()
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

    /// Submits one recorded command buffer and waits for it.
    pub(super) fn submit(&self, commands: vk::CommandBuffer, doing: &str) -> Result<()> {
        self.submit_all(&[commands], doing)
    }

    /// Submits recorded command buffers one by one, and waits for the last.
    pub(super) fn submit_all(&self, commands: &[vk::CommandBuffer], doing: &str) -> Result<()> {
        let raw = &self.0.raw;
        let Some((last, others)) = commands.split_last() else { return Ok(()) };
        if !self.finished() {
            return Err(Error::device(doing, "the device is still busy with what it did not finish in time"));
        }
        let patience = nanoseconds(self.0.patience.get());
        let submit = |commands: vk::CommandBuffer, fence: vk::Fence| {
            let buffers = [commands];
            let info = [vk::SubmitInfo::default().command_buffers(&buffers)];
            // SAFETY: the command buffer is complete and of this device, and so is the fence.
            vk_call("vkQueueSubmit", doing, || unsafe { raw.queue_submit(self.0.queue, &info, fence) })
        };
        // SAFETY: the fence is destroyed once it is not in use.
        unsafe {
            let fence = vk_call("vkCreateFence", doing, || raw.create_fence(&vk::FenceCreateInfo::default(), None))?;
            let submitted = others
                .iter()
                .try_for_each(|commands| submit(*commands, vk::Fence::null()))
                .and_then(|()| submit(*last, fence))
                // Those before the one that was refused may be running.
                .inspect_err(|_| {
                    let _ = raw.queue_wait_idle(self.0.queue);
                });
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

    /// A command buffer ready to record, for one submission.
    pub(super) fn begin(&self, doing: &str) -> Result<vk::CommandBuffer> {
        self.begin_as(vk::CommandBufferLevel::PRIMARY, vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT, doing)
    }

    /// A command buffer of this level and use, ready to record.
    pub(super) fn begin_as(
        &self,
        level: vk::CommandBufferLevel,
        usage: vk::CommandBufferUsageFlags,
        doing: &str,
    ) -> Result<vk::CommandBuffer> {
        let raw = &self.0.raw;
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(self.0.pool).level(level).command_buffer_count(1);
        let inheritance = vk::CommandBufferInheritanceInfo::default();
        let begin = vk::CommandBufferBeginInfo::default().flags(usage).inheritance_info(&inheritance);
        // SAFETY: the pool is this device's and used by one thread at a time.
        unsafe {
            let commands = vk_call("vkAllocateCommandBuffers", doing, || raw.allocate_command_buffers(&info))?[0];
            let begun = vk_call("vkBeginCommandBuffer", doing, || raw.begin_command_buffer(commands, &begin));
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
            self.raw.destroy_pipeline_cache(self.pipeline_cache.get(), None);
            self.raw.destroy_command_pool(self.pool, None);
            self.raw.destroy_device(None);
        }
    }
}
