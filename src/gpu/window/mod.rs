//! Pictures in a window: the picture that a stage has left on the device, with panels over it.
//!
//! The whole window is put together in an image, the canvas, and copied from there to the swapchain. A screenshot is
//! that canvas.

mod image;
mod overlay;
mod surface;

use ash::vk;
use gpu_allocator::MemoryLocation;
use winit::raw_window_handle::HasDisplayHandle;
use winit::window::Window;

use self::image::{Image, LAYER, RANGE, barrier, corners};
pub use self::overlay::Overlay;
use self::overlay::{Canvas, Painter};
pub use self::surface::PresentMode;
use self::surface::{SHOWING, Surface, Swapchain, Turn};
use super::call::vk_call;
use super::instance::Instance;
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use super::vk_error::vk_error;
use crate::error::{Error, Result};

/// A picture on the device.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// Four bytes a pixel, red green blue and one that is ignored, row by row from the top.
    pub buffer: &'a Buffer,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where the window shows it: left, top, width, height, in pixels. A picture of another size is scaled, without a
    /// filter.
    pub area: [u32; 4],
}

impl Instance {
    /// An instance whose devices show pictures in windows of this display; with `validation` see [`Instance::open`].
    pub fn for_windows(validation: bool, display: &impl HasDisplayHandle) -> Result<Self> {
        let doing = "looking for what Vulkan needs to show pictures in windows";
        let display = display.display_handle().map_err(|error| Error::device(doing, error))?;
        let names = ash_window::enumerate_required_extensions(display.as_raw())
            .map_err(|code| vk_error("vkEnumerateInstanceExtensionProperties", doing, code))?;
        Self::with_extensions(validation, names)
    }
}

/// Shows pictures in one window. Drop it before its window.
pub struct Presenter {
    painter: Painter,
    canvas: Option<Canvas>,
    picture: Option<Image>,
    /// None while the window has no area, and until the first frame.
    swapchain: Option<Swapchain>,
    /// None after it was lost.
    surface: Option<Surface>,
    wanted: PresentMode,
    device: LogicalDevice,
}

impl Presenter {
    /// A presenter for a window, on a device of an instance that was made by [`Instance::for_windows`].
    pub fn new(device: &LogicalDevice, window: &Window, wanted: PresentMode) -> Result<Self> {
        let surface = Some(Surface::new(device, window)?);
        let painter = Painter::new(device)?;
        Ok(Self { painter, canvas: None, picture: None, swapchain: None, surface, wanted, device: device.clone() })
    }

    /// How frames reach the screen; none before the first one.
    pub fn mode(&self) -> Option<PresentMode> {
        self.swapchain.as_ref().map(|swapchain| swapchain.mode)
    }

    /// Shows a picture, if there is one, with an overlay on it, in a window of this size in pixels. Returns whether the
    /// window shows it: not while it is minimised, nor if its surface has changed; then call this again.
    pub fn show(
        &mut self,
        window: &Window,
        size: [u32; 2],
        shown: Option<Shown<'_>>,
        mut overlay: Overlay,
    ) -> Result<bool> {
        let done = self
            .painter
            .set_textures(&overlay.textures)
            .and_then(|()| if size.contains(&0) { Ok(false) } else { self.draw(window, size, shown, &overlay) });
        let freed = self.painter.free_textures(&overlay.textures);
        overlay.textures.clear();
        done.and_then(|visible| freed.map(|()| visible))
    }

    fn draw(&mut self, window: &Window, size: [u32; 2], shown: Option<Shown<'_>>, overlay: &Overlay) -> Result<bool> {
        if self.canvas.as_ref().is_none_or(|canvas| canvas.image.size != size) {
            self.canvas = None;
            self.canvas = Some(self.painter.canvas(size)?);
        }
        if let Some(shown) = shown
            && self.picture.as_ref().is_none_or(|picture| picture.size != shown.size)
        {
            self.picture = None;
            self.picture = Some(Image::new(&self.device, "picture", shown.size)?);
        }
        let surface = match &mut self.surface {
            Some(surface) => surface,
            lost => lost.insert(Surface::new(&self.device, window)?),
        };
        if self.swapchain.is_none() {
            self.swapchain = Swapchain::new(surface, self.wanted, size)?;
        }
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        let turn = match swapchain.acquire()? {
            Turn::Image { index, suits } => {
                self.compose(index, shown, overlay)?;
                match (self.swapchain.as_ref().map_or(Ok(Turn::Later), |swapchain| swapchain.present(index))?, suits) {
                    // A swapchain that no longer suits shows this frame, and is replaced.
                    (Turn::Image { suits: true, .. }, true) => return Ok(true),
                    (Turn::Image { .. }, _) => {
                        self.swapchain = None;
                        return Ok(true);
                    }
                    (turn, _) => turn,
                }
            }
            turn => turn,
        };
        if !matches!(turn, Turn::Later) {
            self.swapchain = None;
        }
        if matches!(turn, Turn::SurfaceLost) {
            self.surface = None;
        }
        Ok(false)
    }

    /// Puts the window's content together and copies it to an image of the swapchain.
    fn compose(&mut self, index: u32, shown: Option<Shown<'_>>, overlay: &Overlay) -> Result<()> {
        let commands = self.device.begin(SHOWING)?;
        let done = self.record(commands, index, shown, overlay).and_then(|()| {
            let Some(swapchain) = &self.swapchain else { return Ok(()) };
            let (wait, signal) = ([swapchain.acquired], [swapchain.drawn[index as usize]]);
            let buffers = [commands];
            let info = vk::SubmitInfo::default()
                .command_buffers(&buffers)
                .wait_semaphores(&wait)
                .wait_dst_stage_mask(&[vk::PipelineStageFlags::TRANSFER])
                .signal_semaphores(&signal);
            self.device.submit_each(&[info], SHOWING)
        });
        self.device.discard(commands);
        done
    }

    fn record(
        &mut self,
        commands: vk::CommandBuffer,
        index: u32,
        shown: Option<Shown<'_>>,
        overlay: &Overlay,
    ) -> Result<()> {
        use vk::{AccessFlags as Access, ImageLayout as Layout};
        let (Some(canvas), Some(swapchain)) = (&self.canvas, &self.swapchain) else { return Ok(()) };
        let (raw, target) = (self.device.raw(), canvas.image.raw);
        let (copying, none) = (vk::PipelineStageFlags::TRANSFER, vk::DependencyFlags::empty());
        let fresh = [Layout::UNDEFINED, Layout::TRANSFER_DST_OPTIMAL];
        // SAFETY: the command buffer is recording; all images and the buffer live until it has been waited for, and
        // every region lies within its image.
        unsafe {
            let before = vk::PipelineStageFlags::COMPUTE_SHADER | copying;
            let ordered = |images: &[vk::ImageMemoryBarrier<'_>]| {
                let written = [vk::MemoryBarrier::default()
                    .src_access_mask(Access::SHADER_WRITE)
                    .dst_access_mask(Access::TRANSFER_READ)];
                raw.cmd_pipeline_barrier(commands, before, copying, none, &written, &[], images);
            };

            // The picture on a black canvas.
            let write = [Access::TRANSFER_READ, Access::TRANSFER_WRITE];
            ordered(&[barrier(target, fresh, write)]);
            let black = vk::ClearColorValue::default();
            raw.cmd_clear_color_image(commands, target, fresh[1], &black, &[RANGE]);
            if let (Some(shown), Some(picture)) = (shown, &self.picture) {
                ordered(&[barrier(picture.raw, fresh, write)]);
                let [width, height] = shown.size;
                let whole = vk::BufferImageCopy::default().image_subresource(LAYER).image_extent(vk::Extent3D {
                    width,
                    height,
                    depth: 1,
                });
                raw.cmd_copy_buffer_to_image(commands, shown.buffer.raw, picture.raw, fresh[1], &[whole]);
                let source = [Layout::TRANSFER_DST_OPTIMAL, Layout::TRANSFER_SRC_OPTIMAL];
                let again = [Access::TRANSFER_WRITE; 2];
                ordered(&[
                    barrier(picture.raw, source, [Access::TRANSFER_WRITE, Access::TRANSFER_READ]),
                    barrier(target, [fresh[1]; 2], again),
                ]);
                let to = corners(within(shown.area, canvas.image.size));
                blit(raw, commands, (picture.raw, picture.corners()), (target, to));
            }
        }

        // The overlay on it, and a copy of both to the window.
        self.painter.record(commands, canvas, overlay)?;
        let image = swapchain.images[index as usize];
        // SAFETY: as above; the image was acquired.
        unsafe {
            let changed = |from, to, layouts, access| {
                let images = [barrier(image, layouts, access)];
                raw.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &images);
            };
            changed(copying, copying, fresh, [Access::empty(), Access::TRANSFER_WRITE]);
            // While the window is being resized the two may differ.
            let common = [0, 1].map(|k| canvas.image.size[k].min(swapchain.size[k]));
            let part = corners([0, 0, common[0], common[1]]);
            blit(raw, commands, (target, part), (image, part));
            let end = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            changed(copying, end, [fresh[1], Layout::PRESENT_SRC_KHR], [Access::TRANSFER_WRITE, Access::empty()]);
            vk_call("vkEndCommandBuffer", SHOWING, || raw.end_command_buffer(commands))
        }
    }

    /// What the window shows: width and height, and three bytes a pixel, row by row from the top. None before the first
    /// frame.
    pub fn screenshot(&self) -> Result<Option<([u32; 2], Vec<u8>)>> {
        let doing = "reading what the window shows";
        let Some(Canvas { image, .. }) = &self.canvas else { return Ok(None) };
        let [width, height] = image.size;
        let bytes = u64::from(width) * u64::from(height) * 4;
        let mut staging = Buffer::in_memory(&self.device, "screenshot", bytes, MemoryLocation::GpuToCpu)?;
        let commands = self.device.begin(doing)?;
        let whole = vk::BufferImageCopy::default().image_subresource(LAYER).image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        });
        let visible = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ)];
        let (raw, source) = (self.device.raw(), vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        let stages = [vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST];
        let none = vk::DependencyFlags::empty();
        // SAFETY: a frame leaves the canvas in this layout; the wait ends all use.
        let done = unsafe {
            raw.cmd_copy_image_to_buffer(commands, image.raw, source, staging.raw, &[whole]);
            raw.cmd_pipeline_barrier(commands, stages[0], stages[1], none, &visible, &[], &[]);
            vk_call("vkEndCommandBuffer", doing, || raw.end_command_buffer(commands))
        };
        let done = done.and_then(|()| self.device.submit(commands, doing));
        self.device.discard(commands);
        done?;
        let pixels = staging.mapped(doing)?[..bytes as usize].chunks_exact(4);
        Ok(Some((image.size, pixels.flat_map(|pixel| pixel[..3].to_vec()).collect())))
    }
}

/// The part of a rectangle that lies within a canvas.
fn within([left, top, width, height]: [u32; 4], size: [u32; 2]) -> [u32; 4] {
    let (left, top) = (left.min(size[0] - 1), top.min(size[1] - 1));
    [left, top, width.clamp(1, size[0] - left), height.clamp(1, size[1] - top)]
}

/// Copies a part of an image to a part of another one, scaled without a filter.
///
/// # Safety
///
/// The command buffer is recording; the images are in the layouts of a copy, and live until it has been waited for.
unsafe fn blit(
    raw: &ash::Device,
    commands: vk::CommandBuffer,
    from: (vk::Image, [vk::Offset3D; 2]),
    to: (vk::Image, [vk::Offset3D; 2]),
) {
    let region =
        [vk::ImageBlit { src_subresource: LAYER, src_offsets: from.1, dst_subresource: LAYER, dst_offsets: to.1 }];
    let layouts = [vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL];
    // SAFETY: by this function's own contract.
    unsafe { raw.cmd_blit_image(commands, from.0, layouts[0], to.0, layouts[1], &region, vk::Filter::NEAREST) };
}
