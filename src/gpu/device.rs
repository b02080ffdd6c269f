//! An opened device: its queue, its allocator and its pipeline cache.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::rc::Rc;
use std::sync::Mutex;
use std::time::Duration;

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::faults::tried;
use super::instance::{Adapter, Instance, Limits};
use super::kernel::{Kernel, Key};
use crate::error::{Error, Result};

/// Longest that a submission is waited for, unless [`Device::wait_at_most`] says otherwise.
const PATIENCE: Duration = Duration::from_secs(600);
/// How much longer a submission that was late is waited for before what it uses is freed.
const GRACE: Duration = Duration::from_secs(1);

/// A device with one compute queue. Clones share it; it stays on its thread, because its queue and command pool do.
#[derive(Clone)]
pub struct Device(pub(super) Rc<Inner>, pub(super) Rc<Kit>);

/// The kernels that are made with a device, and what is special about them.
#[derive(Default)]
pub(super) struct Kit {
    /// SPIR-V that takes the place of the build's, by kernel.
    pub(super) replaced: BTreeMap<String, Vec<u32>>,
    /// Whether kernels count what they do.
    pub(super) counts: bool,
    /// Those made so far that do not count.
    pub(super) made: RefCell<BTreeMap<Key, Rc<Kernel>>>,
}

pub(super) struct Inner {
    pub(super) raw: ash::Device,
    pub(super) debug: Option<ext::debug_utils::Device>,
    pub(super) queue: vk::Queue,
    pub(super) pool: vk::CommandPool,
    pub(super) cache: vk::PipelineCache,
    /// `None` only while the device is being destroyed.
    pub(super) allocator: Mutex<Option<Allocator>>,
    pub(super) adapter: Adapter,
    /// Bytes allocated now, and the most since [`Device::forget_peak`].
    pub(super) allocated: Cell<(u64, u64)>,
    /// Longest that a submission is waited for.
    patience: Cell<Duration>,
    /// The fence of a submission that has not ended; null where there is none, as there should be.
    late: Cell<vk::Fence>,
    /// How long that is waited for before what it uses is left alone for ever.
    grace: Cell<Duration>,
    instance: Instance,
}

impl Device {
    /// Opens an adapter, or says why it can't be used.
    pub fn open(instance: &Instance, adapter: &Adapter) -> Result<Self> {
        let doing = format!("opening {}", adapter.name);
        if let Some(why) = &adapter.unusable {
            return Err(Error::device(doing, why));
        }
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(adapter.queue_family)
            .queue_priorities(&priorities)];
        let mut features = vk::PhysicalDeviceVulkan12Features::default().scalar_block_layout(true);
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
        let raw = tried("vkCreateDevice", &doing, || {
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
            cache: vk::PipelineCache::null(),
            allocator: Mutex::new(None),
            adapter: adapter.clone(),
            allocated: Cell::default(),
            patience: Cell::new(PATIENCE),
            late: Cell::default(),
            grace: Cell::new(GRACE),
            instance: instance.clone(),
        };

        // What follows lands in `inner` at once, so that a failure frees what came before it.
        let description = AllocatorCreateDesc {
            instance: inner.instance.0.raw.clone(),
            device: inner.raw.clone(),
            physical_device: adapter.physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: AllocationSizes::default(),
        };
        inner.allocator =
            Mutex::new(Some(Allocator::new(&description).map_err(|error| Error::device(doing.as_str(), error))?));
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(adapter.queue_family);
        // SAFETY: the device is alive.
        unsafe {
            inner.pool = tried("vkCreateCommandPool", &doing, || inner.raw.create_command_pool(&pool, None))?;
            let info = vk::PipelineCacheCreateInfo::default();
            inner.cache = tried("vkCreatePipelineCache", &doing, || inner.raw.create_pipeline_cache(&info, None))?;
        }
        Ok(Self(Rc::new(inner), Rc::default()))
    }

    /// The best usable device, by its kind and then in the loader's order; none where there is none.
    pub fn first() -> Result<Option<Self>> {
        let instance = Instance::open(false)?;
        let adapters = instance.adapters()?;
        Adapter::best(&adapters).map(|adapter| Self::open(&instance, adapter)).transpose()
    }

    /// The same device, where this SPIR-V takes the place of a kernel of the build. Nothing is checked: see `measure::replace`.
    #[must_use]
    pub fn replacing(&self, kernel: &str, words: Vec<u32>) -> Self {
        let mut replaced = self.1.replaced.clone();
        replaced.insert(kernel.to_string(), words);
        Self(self.0.clone(), Rc::new(Kit { replaced, counts: self.1.counts, ..Kit::default() }))
    }

    /// The same device, where kernels count what they do, and take their time about it: see [`super::Kernels::tallies`].
    #[must_use]
    pub fn counting(&self) -> Self {
        Self(self.0.clone(), Rc::new(Kit { replaced: self.1.replaced.clone(), counts: true, ..Kit::default() }))
    }

    /// The kernels that do not come from the build.
    pub fn replaced(&self) -> impl Iterator<Item = &str> {
        self.1.replaced.keys().map(String::as_str)
    }

    /// Bytes of device memory allocated now, and the most at once since [`Self::forget_peak`]; copies' staging counts.
    pub fn memory(&self) -> (u64, u64) {
        self.0.allocated.get()
    }

    /// The most memory is counted anew from here.
    pub fn forget_peak(&self) {
        let (now, _) = self.memory();
        self.0.allocated.set((now, now));
    }

    /// The names of all that is allocated.
    pub fn allocations(&self) -> Vec<String> {
        let Ok(allocator) = self.0.allocator.lock() else { return Vec::new() };
        let report = allocator.as_ref().map(Allocator::generate_report);
        report.map(|report| report.allocations.into_iter().map(|one| one.name).collect()).unwrap_or_default()
    }

    /// How long a submission may take before the device counts as hung; ten minutes otherwise.
    pub fn wait_at_most(&self, patience: Duration) {
        self.0.patience.set(patience);
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

    /// Submits one recorded command buffer and waits for it.
    pub(super) fn submit(&self, commands: vk::CommandBuffer, doing: &str) -> Result<()> {
        let (raw, buffers) = (&self.0.raw, [commands]);
        if !self.finished() {
            return Err(Error::device(doing, "the device is still busy with what it did not finish in time"));
        }
        let info = [vk::SubmitInfo::default().command_buffers(&buffers)];
        let patience = nanoseconds(self.0.patience.get());
        // SAFETY: the command buffer is complete and of this device; the fence is destroyed once it is no longer in use.
        unsafe {
            let fence = tried("vkCreateFence", doing, || raw.create_fence(&vk::FenceCreateInfo::default(), None))?;
            let submitted = tried("vkQueueSubmit", doing, || raw.queue_submit(self.0.queue, &info, fence));
            let waited = submitted.is_ok();
            let done = submitted
                .and_then(|()| tried("vkWaitForFences", doing, || raw.wait_for_fences(&[fence], true, patience)));
            if waited && done.is_err() {
                self.0.late.set(fence);
            } else {
                raw.destroy_fence(fence, None);
            }
            done
        }
    }

    /// Whether nothing is running on the device, so that what it used may be freed. Something is only after a wait that
    /// failed; it is given a moment more, and what it uses is never freed if that is not enough.
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
            let commands = tried("vkAllocateCommandBuffers", doing, || raw.allocate_command_buffers(&info))?[0];
            let begun = tried("vkBeginCommandBuffer", doing, || raw.begin_command_buffer(commands, &once));
            begun.inspect_err(|_| self.discard(commands)).map(|()| commands)
        }
    }

    /// Frees a command buffer, unless it is running still.
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
            // A name that could not be set is no loss.
            let _ = tried("vkSetDebugUtilsObjectNameEXT", "naming", || {
                // SAFETY: the handle is alive.
                unsafe { debug.set_debug_utils_object_name(&info) }
            });
        }
    }
}

impl Inner {
    /// See [`Device::finished`].
    pub(super) fn finished(&self) -> bool {
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

/// As Vulkan counts time.
fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Drop for Inner {
    fn drop(&mut self) {
        let allocator = self.allocator.lock().ok().and_then(|mut allocator| allocator.take());
        if !self.finished() {
            // What a device that hangs may still use is left to the end of the process.
            std::mem::forget((allocator, self.instance.clone()));
            return;
        }
        // SAFETY: buffers and kernels hold a clone of the device, so none is left; the allocator goes before it.
        unsafe {
            let _ = tried("vkDeviceWaitIdle", "closing the device", || self.raw.device_wait_idle());
            drop(allocator);
            self.raw.destroy_pipeline_cache(self.cache, None);
            self.raw.destroy_command_pool(self.pool, None);
            self.raw.destroy_device(None);
        }
    }
}
