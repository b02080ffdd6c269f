//! Events that are played from a file, done as mouse and keyboard do them.

use std::path::Path;

use winit::dpi::PhysicalSize;
use winit::event::MouseButton;

use milkglass::error::Result;
use milkglass::internals::view::picture::save_png;

use super::App;
use crate::cli::view::drag;
use crate::cli::view::frames::Progress;
use crate::cli::view::play::{Button, Deed, Seen};

impl App {
    /// Does what the next event of `--play` asks for.
    pub(super) fn play(&mut self, size: [u32; 2]) -> Result<()> {
        let whole = self.viewer.frames.progress == Progress::Whole && !self.viewer.plays();
        let settled = whole && self.viewer.frames.due(false).is_none();
        let seen = Seen { whole, settled, message: self.viewer.message.is_some(), size };
        let Some(play) = &mut self.play else { return Ok(()) };
        for deed in play.next(seen) {
            match deed {
                Deed::Key(name) => self.key(&name)?,
                Deed::Move(to) => {
                    let scale = f64::from(self.egui.pixels_per_point());
                    self.feed(egui::Event::PointerMoved(egui::pos2((to[0] / scale) as f32, (to[1] / scale) as f32)));
                    self.moved(to)?;
                }
                Deed::Press(button, pressed) => {
                    let (egui, winit) = match button {
                        Button::Left => (egui::PointerButton::Primary, MouseButton::Left),
                        Button::Middle => (egui::PointerButton::Middle, MouseButton::Middle),
                        Button::Right => (egui::PointerButton::Secondary, MouseButton::Right),
                    };
                    let scale = f64::from(self.egui.pixels_per_point());
                    let [x, y] = self.pointer.map(|x| (x / scale) as f32);
                    let (pos, modifiers) = (egui::pos2(x, y), egui::Modifiers::NONE);
                    self.feed(egui::Event::PointerButton { pos, button: egui, pressed, modifiers });
                    self.pressed(winit, pressed);
                }
                Deed::Wheel(lines) => self.perform(drag::wheel(lines))?,
                Deed::Set(set) => self.viewer.setting(&set)?,
                Deed::Resize([width, height]) => {
                    if let Some(shell) = &self.shell {
                        let _ = shell.window.request_inner_size(PhysicalSize::new(width, height));
                    }
                }
                Deed::Screenshot(file) => self.shoot(&file)?,
                Deed::Close => self.viewer.quits = true,
            }
        }
        Ok(())
    }

    /// Gives the panel an event.
    fn feed(&mut self, event: egui::Event) {
        if let Some(shell) = &mut self.shell {
            shell.input.egui_input_mut().events.push(event);
        }
    }

    /// Writes what the window shows, as a PNG file.
    pub(super) fn shoot(&self, file: &Path) -> Result<()> {
        let shot = self.shell.as_ref().map_or(Ok(None), |shell| shell.presenter.screenshot())?;
        let Some((size, bytes)) = shot else { return Ok(()) };
        save_png(file, size.map(|side| side as usize), &bytes)
    }
}
