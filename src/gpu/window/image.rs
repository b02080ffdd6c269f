//! Images on a device: what a window shows is put together in them.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::super::call::vk_call;
use super::super::logical_device::LogicalDevice;
use crate::error::Result;

/// Four channels of 8 bits without a curve: the bytes of stage `tone`, and of what is drawn over its picture.
pub(super) const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// The only layer and level of an image.
pub(super) const LAYER: vk::ImageSubresourceLayers = vk::ImageSubresourceLayers {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    mip_level: 0,
    base_array_layer: 0,
    layer_count: 1,
};

/// The only layer and level of an image, as a range.
pub(super) const RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// An image of format [`FORMAT`] with a view of it. Freed when dropped.
pub(super) struct Image {
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    /// Width and height in pixels, each at least 1.
    pub(super) size: [u32; 2],
    allocation: Option<Allocation>,
    device: LogicalDevice,
}

impl Image {
    /// An image that can be copied from and to, and drawn into.
    pub(super) fn new(device: &LogicalDevice, name: &str, size: [u32; 2]) -> Result<Self> {
        let doing = format!("allocating an image of {} x {} pixels for {name}", size[0], size[1]);
        let usage = vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(FORMAT)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage);
        let raw = vk_call("vkCreateImage", &doing, || {
            // SAFETY: the device is alive.
            unsafe { device.raw().create_image(&info, None) }
        })?;
        let mut image = Self { raw, view: vk::ImageView::null(), size, allocation: None, device: device.clone() };
        device.label(raw, name);
        // SAFETY: the image was just created.
        let requirements = unsafe { device.raw().get_image_memory_requirements(raw) };
        let description = AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = image.allocation.insert(device.heap().allocate(&description, &doing)?);
        vk_call("vkBindImageMemory", &doing, || {
            // SAFETY: memory and offset come from the allocator for exactly these requirements.
            unsafe { device.raw().bind_image_memory(raw, allocation.memory(), allocation.offset()) }
        })?;
        let info = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(FORMAT)
            .subresource_range(RANGE);
        image.view = vk_call("vkCreateImageView", &doing, || {
            // SAFETY: the image is alive and has its memory.
            unsafe { device.raw().create_image_view(&info, None) }
        })?;
        device.label(image.view, name);
        Ok(image)
    }

    /// Its corners as a region of a blit.
    pub(super) fn corners(&self) -> [vk::Offset3D; 2] {
        corners([0, 0, self.size[0], self.size[1]])
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        // SAFETY: every submission is waited for, so the device no longer uses the image.
        unsafe {
            self.device.raw().destroy_image_view(self.view, None);
            self.device.raw().destroy_image(self.raw, None);
        }
        if let Some(allocation) = self.allocation.take() {
            self.device.heap().free(allocation);
        }
    }
}

/// The corners of a rectangle: left, top, width, height, in pixels.
pub(super) fn corners([left, top, width, height]: [u32; 4]) -> [vk::Offset3D; 2] {
    let at = |x: u32, y: u32, z| vk::Offset3D { x: x as i32, y: y as i32, z };
    [at(left, top, 0), at(left + width, top + height, 1)]
}

/// A barrier of copies, blits and clears: an image changes its layout, and what was written is visible afterwards.
pub(super) fn barrier(
    image: vk::Image,
    [from, to]: [vk::ImageLayout; 2],
    [before, after]: [vk::AccessFlags; 2],
) -> vk::ImageMemoryBarrier<'static> {
    vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(from)
        .new_layout(to)
        .src_access_mask(before)
        .dst_access_mask(after)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(RANGE)
}
