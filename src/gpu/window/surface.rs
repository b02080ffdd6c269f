//! A window's surface and its swapchain: the images that the window shows in turn.

use ash::{khr, vk};
use winit::raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle};
use winit::window::Window;

use super::super::call::vk_call;
use super::super::logical_device::LogicalDevice;
use crate::error::{Error, Result};

/// What the program is doing here, for errors.
pub(super) const SHOWING: &str = "showing a picture in the window";

/// How long the window system may take to return an image, ns; after that the frame is not shown.
const TURN: u64 = 1_000_000_000;

/// How finished frames reach the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum PresentMode {
    /// Each frame is shown, at the screen's pace.
    #[default]
    Fifo,
    /// The latest frame is shown; `fifo` where the window system does not offer it.
    Mailbox,
}

/// A window's surface. Freed when dropped.
pub(super) struct Surface {
    raw: vk::SurfaceKHR,
    functions: khr::surface::Instance,
    device: LogicalDevice,
}

impl Surface {
    /// The surface of this window, on which the device's queue can present.
    pub(super) fn new(device: &LogicalDevice, window: &Window) -> Result<Self> {
        let lost = |error: HandleError| Error::device(SHOWING, error);
        let display = window.display_handle().map_err(lost)?.as_raw();
        let handle = window.window_handle().map_err(lost)?.as_raw();
        let instance = &device.instance().0;
        let raw = vk_call("vkCreateSurfaceKHR", SHOWING, || {
            // SAFETY: the handles are of a window that is alive, and the instance has the extensions for it.
            unsafe { ash_window::create_surface(&instance.entry, &instance.raw, display, handle, None) }
        })?;
        let functions = khr::surface::Instance::new(&instance.entry, &instance.raw);
        // Without a name: Mesa 22.3 takes what belongs to the window system for objects of its own, and crashes.
        let surface = Self { raw, functions, device: device.clone() };
        let (adapter, doing) = (device.adapter(), "asking whether the device can show pictures in this window");
        let shows = vk_call("vkGetPhysicalDeviceSurfaceSupportKHR", doing, || {
            let (physical, family) = (adapter.physical, adapter.queue_family);
            // SAFETY: the surface and the adapter are of the same instance.
            unsafe { surface.functions.get_physical_device_surface_support(physical, family, raw) }
        })?;
        // SAFETY: a plain query.
        let families = unsafe { instance.raw.get_physical_device_queue_family_properties(device.adapter().physical) };
        let draws = families
            .get(adapter.queue_family as usize)
            .is_some_and(|family| family.queue_flags.contains(vk::QueueFlags::GRAPHICS));
        if !(shows && draws) {
            let what = format!("{} can't show pictures in this window; use another --device", adapter.name);
            return Err(Error::device(doing, what));
        }
        Ok(surface)
    }

    /// What the surface allows now.
    fn capabilities(&self) -> Result<vk::SurfaceCapabilitiesKHR> {
        vk_call("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", SHOWING, || {
            // SAFETY: the surface is alive.
            unsafe { self.functions.get_physical_device_surface_capabilities(self.device.adapter().physical, self.raw) }
        })
    }

    /// A format of 8 bits a channel without a curve: pictures have theirs already.
    fn format(&self) -> Result<vk::SurfaceFormatKHR> {
        let physical = self.device.adapter().physical;
        let offered = vk_call("vkGetPhysicalDeviceSurfaceFormatsKHR", SHOWING, || {
            // SAFETY: the surface is alive.
            unsafe { self.functions.get_physical_device_surface_formats(physical, self.raw) }
        })?;
        let plain = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM, vk::Format::A8B8G8R8_UNORM_PACK32];
        offered.into_iter().find(|offer| plain.contains(&offer.format)).ok_or_else(|| {
            Error::device(SHOWING, "its surface has no format of 8 bits a channel without a curve of its own")
        })
    }

    /// The wanted way to present, or FIFO, which every surface has.
    fn mode(&self, wanted: PresentMode) -> Result<vk::PresentModeKHR> {
        let physical = self.device.adapter().physical;
        let offered = vk_call("vkGetPhysicalDeviceSurfacePresentModesKHR", SHOWING, || {
            // SAFETY: the surface is alive.
            unsafe { self.functions.get_physical_device_surface_present_modes(physical, self.raw) }
        })?;
        let mailbox = wanted == PresentMode::Mailbox && offered.contains(&vk::PresentModeKHR::MAILBOX);
        Ok(if mailbox { vk::PresentModeKHR::MAILBOX } else { vk::PresentModeKHR::FIFO })
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        if self.device.finished() {
            // SAFETY: the swapchain is gone, as [`super::Presenter`] drops it first.
            unsafe { self.functions.destroy_surface(self.raw, None) };
        }
    }
}

/// The images of a surface. Freed when dropped.
pub(super) struct Swapchain {
    raw: vk::SwapchainKHR,
    functions: khr::swapchain::Device,
    pub(super) images: Vec<vk::Image>,
    /// Width and height of the images in pixels.
    pub(super) size: [u32; 2],
    /// Signalled when the window system returns an image.
    pub(super) acquired: vk::Semaphore,
    /// For each image: signalled when it is drawn.
    pub(super) drawn: Vec<vk::Semaphore>,
    /// The way it presents.
    pub(super) mode: PresentMode,
    device: LogicalDevice,
}

impl Swapchain {
    /// Images for a window of this size in pixels; none while it has no area, as when it is minimised.
    pub(super) fn new(surface: &Surface, wanted: PresentMode, window: [u32; 2]) -> Result<Option<Self>> {
        let (device, can) = (&surface.device, surface.capabilities()?);
        let size = match can.current_extent {
            // The swapchain decides.
            vk::Extent2D { width: u32::MAX, .. } => [
                window[0].clamp(can.min_image_extent.width, can.max_image_extent.width),
                window[1].clamp(can.min_image_extent.height, can.max_image_extent.height),
            ],
            vk::Extent2D { width, height } => [width, height],
        };
        if size.contains(&0) {
            return Ok(None);
        }
        if !can.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(Error::device(SHOWING, "pictures can't be copied to its surface; use another --device"));
        }
        let (format, mode) = (surface.format()?, surface.mode(wanted)?);
        let alpha = if can.supported_composite_alpha.contains(vk::CompositeAlphaFlagsKHR::OPAQUE) {
            vk::CompositeAlphaFlagsKHR::OPAQUE
        } else {
            vk::CompositeAlphaFlagsKHR::INHERIT
        };
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(vk::Extent2D { width: size[0], height: size[1] })
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(can.current_transform)
            .composite_alpha(alpha)
            .present_mode(mode)
            .clipped(true);
        let functions = khr::swapchain::Device::new(&device.instance().0.raw, device.raw());
        let raw = vk_call("vkCreateSwapchainKHR", SHOWING, || {
            // SAFETY: the surface is alive and has no other swapchain.
            unsafe { functions.create_swapchain(&info, None) }
        })?;
        let mut swapchain = Self {
            raw,
            functions,
            images: Vec::new(),
            size,
            acquired: vk::Semaphore::null(),
            drawn: Vec::new(),
            mode: if mode == vk::PresentModeKHR::MAILBOX { PresentMode::Mailbox } else { PresentMode::Fifo },
            device: device.clone(),
        };
        swapchain.images = vk_call("vkGetSwapchainImagesKHR", SHOWING, || {
            // SAFETY: the swapchain is alive.
            unsafe { swapchain.functions.get_swapchain_images(raw) }
        })?;
        swapchain.acquired = semaphore(device, "image acquired")?;
        for _ in &swapchain.images {
            swapchain.drawn.push(semaphore(device, "image drawn")?);
        }
        Ok(Some(swapchain))
    }

    /// The index of the next image, which may be drawn to once `acquired` is signalled, and whether the swapchain still
    /// suits the surface.
    pub(super) fn acquire(&self) -> Result<Turn> {
        vk_call("vkAcquireNextImageKHR", SHOWING, || {
            // SAFETY: the semaphore has been waited for since its last signal.
            let turn = unsafe { self.functions.acquire_next_image(self.raw, TURN, self.acquired, vk::Fence::null()) };
            match turn {
                Ok((index, suboptimal)) => Ok(Turn::Image { index, suits: !suboptimal }),
                Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(Turn::Later),
                Err(code) => Turn::lost(code),
            }
        })
    }

    /// Shows an image that was drawn; returns what has become of the swapchain.
    pub(super) fn present(&self, index: u32) -> Result<Turn> {
        let (drawn, swapchains, indices) = ([self.drawn[index as usize]], [self.raw], [index]);
        let info =
            vk::PresentInfoKHR::default().wait_semaphores(&drawn).swapchains(&swapchains).image_indices(&indices);
        vk_call("vkQueuePresentKHR", SHOWING, || {
            // SAFETY: the image was acquired and drawn; the queue is used by one thread.
            match unsafe { self.functions.queue_present(self.device.queue(), &info) } {
                Ok(suboptimal) => Ok(Turn::Image { index, suits: !suboptimal }),
                Err(code) => Turn::lost(code),
            }
        })
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        let raw = self.device.raw();
        // SAFETY: nothing is being drawn; the wait ends what the window system does with the semaphores.
        unsafe {
            let _ = vk_call("vkDeviceWaitIdle", SHOWING, || raw.device_wait_idle());
            self.drawn.iter().for_each(|drawn| raw.destroy_semaphore(*drawn, None));
            raw.destroy_semaphore(self.acquired, None);
            self.functions.destroy_swapchain(self.raw, None);
        }
    }
}

/// What the window system answers.
pub(super) enum Turn {
    /// An image, and whether the swapchain still suits the surface.
    Image { index: u32, suits: bool },
    /// No image in time: the frame is not shown.
    Later,
    /// The surface has changed: it needs another swapchain.
    OutOfDate,
    /// The surface is gone: the window needs another one.
    SurfaceLost,
}

impl Turn {
    fn lost(code: vk::Result) -> std::result::Result<Self, vk::Result> {
        match code {
            vk::Result::ERROR_OUT_OF_DATE_KHR => Ok(Self::OutOfDate),
            vk::Result::ERROR_SURFACE_LOST_KHR => Ok(Self::SurfaceLost),
            other => Err(other),
        }
    }
}

fn semaphore(device: &LogicalDevice, name: &str) -> Result<vk::Semaphore> {
    let made = vk_call("vkCreateSemaphore", SHOWING, || {
        // SAFETY: the device is alive.
        unsafe { device.raw().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
    });
    made.inspect(|semaphore| device.label(*semaphore, name))
}
