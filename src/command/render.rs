//! `milkglass render`: a picture of a scene.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::{RunArguments, SceneArguments, check_messages, open_session, validation};
use crate::error::{Input, Result};
use crate::render::aov::layers;
use crate::render::plan::{Change, Mode, Options};
use crate::render::samples::picture;
use crate::view::aov::save;
use crate::view::picture::check;

/// Arguments of `render`.
#[derive(Args)]
#[command(after_help = "Example: milkglass render lotus -o lotus.png --size 800x600 --set camera.exposure=1.5")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    /// The picture: `.png` (exposed, toned, sRGB) or `.exr` (linear).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels; overrides the scene's.
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// Add layers to an `.exr`: irradiance, radiosity, normal, error_estimate, depth, object, triangle, links.
    #[arg(long)]
    aov: bool,
    /// Print each stage's time.
    #[arg(long)]
    times: bool,
}

/// Renders and writes the picture.
pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    check(&arguments.output)?;
    let aov = arguments.aov;
    if aov && !arguments.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        let found = arguments.output.display();
        return Err(Input::new("only OpenEXR has layers").key("--aov").found(found).expected("-o FILE.exr").into());
    }
    let mut scene = arguments.scene.load()?;
    if let Some(text) = &arguments.size {
        scene.camera.size = parse_size(text)?;
    }
    let device = arguments.run.device.open(validation())?;
    let mut options = arguments.run.options();
    if aov {
        // Lists are kept, because a layer tells how long they are.
        options = Options { estimate: true, mode: Mode::Render, ..options };
    }
    let mut session = open_session(&scene, device.as_ref(), options)?;
    let times = session.frame(Change::EVERYTHING)?;
    if arguments.times {
        super::solve::print_times(&mut session, &times)?;
    }
    // Layers are those of the pixels' centres.
    let layers = if aov { Some(layers(&mut session)?) } else { None };
    let picture = picture(&mut session)?;
    check_messages(device.as_ref())?;
    match layers {
        Some(layers) => save(&picture, &layers, &arguments.output)?,
        None => picture.save(&arguments.output, &scene.camera)?,
    }
    let place = device.as_ref().map_or("the CPU", |device| device.name());
    let seconds = start.elapsed().as_secs_f64();
    let (file, width, height) = (arguments.output.display(), picture.width, picture.height);
    eprintln!("{file}: {width} x {height}, on {place}, {seconds:.1} s");
    Ok(())
}

/// `800x600`, each side from 1 to 16384.
fn parse_size(text: &str) -> Result<[u32; 2]> {
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|n| (1..=16384).contains(n));
    text.split_once(['x', 'X']).and_then(|(w, h)| Some([side(w)?, side(h)?])).ok_or_else(|| {
        Input::new("not a picture size").key("--size").found(text).expected("WxH, each 1 to 16384").into()
    })
}

#[cfg(test)]
mod tests {
    use super::parse_size;

    #[test]
    fn sizes() {
        assert_eq!(parse_size("800x600").unwrap(), [800, 600]);
        assert_eq!(parse_size("1X1").unwrap(), [1, 1]);
        for bad in ["800", "0x5", "5x99999", "axb", "", "1x2x3", "-1x4"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
