//! The window: events of the window system, and frames.

mod deeds;
mod pointer;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, Modifiers, MouseScrollDelta, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

use milkglass::error::{Error, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::gpu::window::{Overlay, PresentMode, Presenter, Shown};

use super::drag::{self, Drag};
use super::keys;
use super::panel::{WIDTH, lay_out};
use super::play::Play;
use super::viewer::Viewer;

/// How often the scene's file is looked at.
const POLL: Duration = Duration::from_millis(500);
/// Pixels of the wheel's movement that count as a line.
const LINE: f64 = 40.0;

/// The program while its window is open.
pub(super) struct App {
    viewer: Viewer,
    device: Device,
    play: Option<Play>,
    pub(super) present: PresentMode,
    /// Frames after which the window closes.
    pub(super) limit: Option<u64>,
    /// The file to which the window is written when it closes.
    pub(super) screenshot: Option<PathBuf>,
    frames: u64,
    polled: Instant,
    /// When the panel wants to be drawn again.
    repaint: Option<Instant>,
    pointer: [f64; 2],
    drag: Option<Drag>,
    /// Whether a control of the panel is being dragged.
    sliding: bool,
    modifiers: Modifiers,
    egui: egui::Context,
    shell: Option<Shell>,
    outcome: Result<()>,
}

/// The open window. What draws into it is dropped first.
struct Shell {
    presenter: Presenter,
    input: egui_winit::State,
    window: Window,
}

impl App {
    pub(super) fn new(viewer: Viewer, device: Device, play: Option<Play>) -> Self {
        Self {
            viewer,
            device,
            play,
            present: PresentMode::Fifo,
            limit: None,
            screenshot: None,
            frames: 0,
            polled: Instant::now(),
            repaint: None,
            pointer: [0.0; 2],
            drag: None,
            sliding: false,
            modifiers: Modifiers::default(),
            egui: egui::Context::default(),
            shell: None,
            outcome: Ok(()),
        }
    }

    /// The outcome, once the window is closed.
    pub(super) fn end(mut self) -> Result<()> {
        self.shell = None;
        self.outcome
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let [width, height] = self.viewer.edits.scene.camera.size;
        let scale = events.primary_monitor().map_or(1.0, |monitor| monitor.scale_factor());
        let size = PhysicalSize::new(width + (f64::from(WIDTH) * scale).round() as u32, height);
        let title = format!("{} - milkglass", self.viewer.edits.scene.name);
        let attributes = Window::default_attributes().with_title(title).with_inner_size(size);
        let doing = "opening a window";
        let window = events.create_window(attributes).map_err(|error| Error::device(doing, error))?;
        let presenter = Presenter::new(&self.device, &window, self.present)?;
        let (egui, scale) = (self.egui.clone(), Some(window.scale_factor() as f32));
        let input = egui_winit::State::new(egui, ViewportId::ROOT, &window, scale, None, None);
        self.shell = Some(Shell { presenter, input, window });
        Ok(())
    }

    /// Looks at the scene's file, now and then.
    fn poll(&mut self) -> Result<()> {
        if self.polled.elapsed() < POLL {
            return Ok(());
        }
        self.polled = Instant::now();
        self.viewer.reload()
    }

    /// One frame: the panel, what was asked for there, a step of rendering, and the result in the window.
    fn frame(&mut self) -> Result<()> {
        self.poll()?;
        let Some(shell) = &mut self.shell else { return Ok(()) };
        let size = <[u32; 2]>::from(shell.window.inner_size());

        // The panel; the picture has what it leaves free.
        let (mut actions, mut free) = (Vec::new(), egui::Rect::ZERO);
        let input = shell.input.take_egui_input(&shell.window);
        let mut output = self.egui.run_ui(input, |ui| {
            actions.clear();
            free = lay_out(ui, &self.viewer.facts(), &mut actions);
        });
        shell.input.handle_platform_output(&shell.window, std::mem::take(&mut output.platform_output));
        let delay = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.repaint = delay.and_then(|delay| Instant::now().checked_add(delay));
        let scale = output.pixels_per_point;
        let primitives = self.egui.tessellate(std::mem::take(&mut output.shapes), scale);
        let textures = std::mem::take(&mut output.textures_delta);
        let overlay = Overlay { primitives, textures, pixels_per_point: scale };

        // The picture.
        let area = [free.width(), free.height()].map(|side| ((side * scale).round() as u32).max(1));
        let rendered = self.render(actions, area, size);
        let Some(shell) = &mut self.shell else { return Ok(()) };
        let shown = rendered.and_then(|()| self.viewer.frames.shown());
        let (picture, failed) = match shown {
            Ok(picture) => (picture, None),
            Err(error) => (None, Some(error)),
        };
        let shown = picture.map(|(size, buffer)| Shown { buffer, size, area: [0, 0, area[0], area[1]] });
        if !shell.presenter.show(&shell.window, size, shown, overlay)? && !size.contains(&0) {
            // There may be no other event after which the window is drawn.
            let soon = Instant::now() + Duration::from_millis(100);
            self.repaint = Some(self.repaint.map_or(soon, |due| due.min(soon)));
        }
        failed.map_or(Ok(()), Err)?;
        self.frames += 1;
        self.play(size)
    }

    /// Does what was asked for, and a step of rendering.
    fn render(&mut self, actions: Vec<keys::Action>, area: [u32; 2], window: [u32; 2]) -> Result<()> {
        for action in actions {
            self.viewer.perform(action, !self.sliding)?;
            self.sliding = self.egui.egui_is_using_pointer();
        }
        self.sliding &= self.egui.egui_is_using_pointer();
        if window.contains(&0) {
            return Ok(());
        }
        self.viewer.resize(area)?;
        self.viewer.tick()?;
        self.viewer.advance(self.drag.is_some() || self.sliding)
    }

    fn key(&mut self, name: &str) -> Result<()> {
        keys::action(name).map_or(Ok(()), |action| self.perform(action))
    }

    /// Does an action that one undo takes back.
    fn perform(&mut self, action: keys::Action) -> Result<()> {
        self.viewer.perform(action, true)
    }

    fn on(&mut self, event: &WindowEvent) -> Result<()> {
        let Some(shell) = &mut self.shell else { return Ok(()) };
        let _ = shell.input.on_window_event(&shell.window, event);
        match event {
            WindowEvent::RedrawRequested => return self.frame(),
            WindowEvent::CloseRequested => self.viewer.quits = true,
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = *modifiers,
            WindowEvent::CursorMoved { position, .. } => self.moved([position.x, position.y])?,
            WindowEvent::MouseInput { state, button, .. } => self.pressed(*button, *state == ElementState::Pressed),
            WindowEvent::MouseWheel { delta, .. } if self.over_picture() => {
                self.perform(drag::wheel(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / LINE,
                }))?;
            }
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => {
                if let Some(name) = keys::name(event, self.modifiers).filter(|_| !self.egui.text_edit_focused()) {
                    self.key(&name)?;
                }
            }
            WindowEvent::Resized(_) | WindowEvent::Occluded(false) | WindowEvent::ScaleFactorChanged { .. } => {}
            _ => return Ok(()),
        }
        if let Some(shell) = &self.shell {
            shell.window.request_redraw();
        }
        Ok(())
    }

    /// When the next frame is due: at once while something is to be done.
    fn due(&self) -> Option<Instant> {
        if self.limit.is_some() || self.play.as_ref().is_some_and(|play| !play.is_over()) {
            return Some(Instant::now());
        }
        if self.viewer.plays() {
            return Some(Instant::now());
        }
        let rendering = self.viewer.frames.due(self.drag.is_some() || self.sliding);
        rendering.into_iter().chain(self.repaint).min()
    }

    /// Closes the window where that is due.
    fn leave(&mut self, done: Result<()>, events: &ActiveEventLoop) {
        let over = self.viewer.quits || self.limit.is_some_and(|limit| self.frames >= limit);
        let shot = match &self.screenshot {
            Some(file) if done.is_ok() && over => self.shoot(file),
            _ => Ok(()),
        };
        let ended = done.and(shot);
        if over || ended.is_err() {
            self.outcome = ended;
            // The screenshot is taken once.
            self.screenshot = None;
            events.exit();
        }
    }
}

impl ApplicationHandler for App {
    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        if !matches!(cause, StartCause::ResumeTimeReached { .. }) {
            return;
        }
        let message = self.viewer.message.clone();
        let polled = self.poll();
        self.leave(polled, events);
        let due = self.due().is_some_and(|due| due <= Instant::now()) || self.viewer.message != message;
        if let Some(shell) = self.shell.as_ref().filter(|_| due) {
            shell.window.request_redraw();
        }
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.shell.is_none() {
            let opened = self.open(events);
            self.leave(opened, events);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        if !events.exiting() {
            let done = self.on(&event);
            self.leave(done, events);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let poll = self.polled + POLL;
        events.set_control_flow(ControlFlow::WaitUntil(self.due().map_or(poll, |due| due.min(poll))));
    }

    fn exiting(&mut self, _events: &ActiveEventLoop) {
        // Before the connection to the window system is closed.
        self.shell = None;
        tell!("{} frames; {}", self.frames, self.viewer.frames.times());
    }
}
