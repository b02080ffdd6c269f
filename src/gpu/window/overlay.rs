//! What is drawn over the picture: the panels of egui, into a canvas.

use ash::vk;
use egui::{ClippedPrimitive, TexturesDelta};
use egui_ash_renderer::allocator::DefaultAllocator;
use egui_ash_renderer::{Options, RenderMode, Renderer, RendererError};

use super::super::call::vk_call;
use super::super::logical_device::LogicalDevice;
use super::image::{FORMAT, Image};
use super::surface::SHOWING;
use crate::error::{Error, Result};

/// Panels as egui has laid them out.
pub struct Overlay {
    /// Triangles.
    pub primitives: Vec<ClippedPrimitive>,
    /// What has changed in the textures since the last overlay; no overlay may be left out.
    pub textures: TexturesDelta,
    /// Pixels of a point, egui's unit of length.
    pub pixels_per_point: f32,
}

/// Draws overlays. Freed when dropped.
pub(super) struct Painter {
    /// None once the device hangs.
    renderer: Option<Renderer<DefaultAllocator>>,
    pass: vk::RenderPass,
    pool: vk::CommandPool,
    device: LogicalDevice,
}

impl Painter {
    pub(super) fn new(device: &LogicalDevice) -> Result<Self> {
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(device.adapter().queue_family);
        let mut painter =
            Self { renderer: None, pass: pass(device)?, pool: vk::CommandPool::null(), device: device.clone() };
        painter.pool = vk_call("vkCreateCommandPool", SHOWING, || {
            // SAFETY: the device is alive.
            unsafe { device.raw().create_command_pool(&pool, None) }
        })?;
        device.label(painter.pass, "panels");
        device.label(painter.pool, "panels");
        let (instance, physical) = (&device.instance().0.raw, device.adapter().physical);
        let (mode, options) = (RenderMode::RenderPass(painter.pass), Options::default());
        let made = Renderer::with_default_allocator(instance, physical, device.raw().clone(), mode, options);
        painter.renderer = Some(made.map_err(|error| fault(&error))?);
        Ok(painter)
    }

    /// Changes the textures before an overlay is drawn.
    pub(super) fn set_textures(&mut self, textures: &TexturesDelta) -> Result<()> {
        let Some(renderer) = &mut self.renderer else { return Ok(()) };
        for (id, delta) in textures.set.iter().flat_map(|(id, deltas)| deltas.iter().map(move |delta| (id, delta))) {
            let done = renderer.set_texture(self.device.queue(), self.pool, *id, delta);
            done.map_err(|error| fault(&error))?;
        }
        Ok(())
    }

    /// Frees textures after the overlay has been drawn.
    pub(super) fn free_textures(&mut self, textures: &TexturesDelta) -> Result<()> {
        let Some(renderer) = &mut self.renderer else { return Ok(()) };
        textures.free.iter().try_for_each(|id| renderer.free_texture(*id)).map_err(|error| fault(&error))
    }

    /// Records the drawing of an overlay. The canvas goes from the layout of a copy's target to that of its source.
    pub(super) fn record(&mut self, commands: vk::CommandBuffer, canvas: &Canvas, overlay: &Overlay) -> Result<()> {
        let [width, height] = canvas.image.size;
        let extent = vk::Extent2D { width, height };
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass)
            .framebuffer(canvas.framebuffer)
            .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent });
        let raw = self.device.raw();
        // SAFETY: the command buffer is recording; pass, framebuffer and textures live until it has been waited for.
        unsafe {
            raw.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            let drawn = self.renderer.as_mut().map_or(Ok(()), |renderer| {
                renderer.cmd_draw(commands, extent, overlay.pixels_per_point, &overlay.primitives)
            });
            raw.cmd_end_render_pass(commands);
            drawn.map_err(|error| fault(&error))
        }
    }

    /// A canvas of this size in pixels.
    pub(super) fn canvas(&self, size: [u32; 2]) -> Result<Canvas> {
        let image = Image::new(&self.device, "canvas", size)?;
        let views = [image.view];
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(self.pass)
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        let framebuffer = vk_call("vkCreateFramebuffer", SHOWING, || {
            // SAFETY: the pass and the view are alive.
            unsafe { self.device.raw().create_framebuffer(&info, None) }
        })?;
        self.device.label(framebuffer, "canvas");
        Ok(Canvas { framebuffer, image, device: self.device.clone() })
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        if !self.device.finished() {
            // What a hung device may still use lives until the process ends.
            std::mem::forget(self.renderer.take());
            return;
        }
        self.renderer = None;
        // SAFETY: nothing is being drawn.
        unsafe {
            self.device.raw().destroy_command_pool(self.pool, None);
            self.device.raw().destroy_render_pass(self.pass, None);
        }
    }
}

/// An image to draw overlays into: what the whole window shows. Freed when dropped.
pub(super) struct Canvas {
    framebuffer: vk::Framebuffer,
    pub(super) image: Image,
    device: LogicalDevice,
}

impl Drop for Canvas {
    fn drop(&mut self) {
        if self.device.finished() {
            // SAFETY: nothing is being drawn.
            unsafe { self.device.raw().destroy_framebuffer(self.framebuffer, None) };
        }
    }
}

/// A pass over an image that has been copied to, and will be copied from.
fn pass(device: &LogicalDevice) -> Result<vk::RenderPass> {
    let attachments = [vk::AttachmentDescription::default()
        .format(FORMAT)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::LOAD)
        .store_op(vk::AttachmentStoreOp::STORE)
        .initial_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
        .final_layout(vk::ImageLayout::TRANSFER_SRC_OPTIMAL)];
    let colors = [vk::AttachmentReference::default().attachment(0).layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&colors)];
    let drawing = vk::AccessFlags::COLOR_ATTACHMENT_READ | vk::AccessFlags::COLOR_ATTACHMENT_WRITE;
    let (copying, output) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT);
    let dependencies = [
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .dst_subpass(0)
            .src_stage_mask(copying)
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_stage_mask(output)
            .dst_access_mask(drawing),
        vk::SubpassDependency::default()
            .src_subpass(0)
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(output)
            .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
            .dst_stage_mask(copying)
            .dst_access_mask(vk::AccessFlags::TRANSFER_READ),
    ];
    let info =
        vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses).dependencies(&dependencies);
    vk_call("vkCreateRenderPass", SHOWING, || {
        // SAFETY: `info` and all it points to live through the call.
        unsafe { device.raw().create_render_pass(&info, None) }
    })
}

fn fault(error: &RendererError) -> Error {
    Error::device(SHOWING, error)
}
