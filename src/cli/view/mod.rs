//! `milkglass view`: a scene in a window.

mod amounts;
mod app;
mod drafts;
mod drag;
mod edits;
mod frames;
mod history;
mod inspect;
mod keys;
mod panel;
mod play;
mod turn;
mod viewer;

use std::path::PathBuf;

use clap::Args;
use winit::event_loop::EventLoop;

use self::app::App;
use self::play::Play;
use self::viewer::Viewer;
use super::render::PictureArguments;
use super::{check_messages, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Instance;
use milkglass::internals::gpu::window::PresentMode;
use milkglass::internals::view::picture::is_png;

/// Arguments of `view`.
#[derive(Args)]
#[command(after_help = "Example: milkglass view lotus --size 800x600
The key ? shows what mouse and keys do.")]
pub struct Arguments {
    #[command(flatten)]
    picture: PictureArguments,
    /// How frames reach the screen.
    #[arg(long, value_enum, default_value_t)]
    present: PresentMode,
    /// Close the window after this many frames.
    #[arg(long, value_name = "N")]
    frames_limit: Option<u64>,
    /// Write what the window shows when it closes, the panel included: `.png`.
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Play the events of this file: keys, drags, sizes, screenshots.
    #[arg(long, value_name = "EVENTS.toml")]
    play: Option<PathBuf>,
}

/// Opens the window, and returns once it is closed.
pub fn run(arguments: &Arguments) -> Result<()> {
    let PictureArguments { scene, bare, run, .. } = &arguments.picture;
    let size = arguments.picture.size()?;
    if bare.turns().is_some() {
        let fault = Input::new("a window has no frames around the mesh").key("--turntable");
        return Err(fault.expected("`render --turntable`").into());
    }
    if let Some(file) = arguments.screenshot.as_ref().filter(|file| !is_png(file)) {
        let fault = Input::new("a screenshot has 8 bits a channel").key("--screenshot").found(file.display());
        return Err(fault.expected("a name that ends in .png").into());
    }
    if run.device.is_cpu() {
        let fault = Input::new("a window shows what a Vulkan device renders").key("--device").found("cpu");
        return Err(fault.expected("a device of `milkglass devices`; lavapipe is one").into());
    }
    let play = arguments.play.as_deref().map(Play::read).transpose()?;
    let events = EventLoop::new().map_err(|error| {
        // The message of the operating system, without the place in the source where it arose.
        let text = error.to_string();
        let what = text.rsplit(".rs:").next().and_then(|rest| rest.split_once(": ")).map_or(&*text, |(_, what)| what);
        Error::device("opening a window", format!("there is no display to open it on: {}", what.replace('\n', " ")))
    })?;
    let device = run.device.open_among(Instance::for_windows(validation(), &events), validation())?;
    let Some(device) = device else {
        return Err(Error::device(
            "opening a window",
            "a window needs a Vulkan device; `milkglass devices` lists them",
        ));
    };
    let subject = arguments.picture.subject()?;
    let scene = run.of(scene).words().into_iter().filter(|word| !word.starts_with("--frame="));
    let words = scene.chain(bare.words()).chain(run.device.words()).collect();
    let viewer = Viewer::new(subject, size, &device, run.option_args, words)?;
    let mut app = App::new(viewer, device.clone(), play);
    app.present = arguments.present;
    app.limit = arguments.frames_limit;
    app.screenshot.clone_from(&arguments.screenshot);
    let ended = events.run_app(&mut app).map_err(|error| Error::device("showing a window", error));
    app.end()?;
    ended?;
    check_messages(Some(&device))
}
