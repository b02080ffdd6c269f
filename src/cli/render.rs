//! `milkglass render`: a picture of a scene.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};

use super::bare::{BareArguments, Subject};
use super::long_work::tell_long_work;
use super::samples::{Samples, foretell};
use super::solve::FRAMES;
use super::{
    RunArguments, SceneArguments, check_messages, open_session, print, run_first_sample, run_frame, sequence, table,
    validation,
};
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::phases::phase;
use milkglass::internals::pipeline::plan::{Change, Mode, Options, ShadingMethod};
use milkglass::internals::session::cluster_view::{Emitters, clusters, color};
use milkglass::internals::session::curvature_view::{CurvatureView, curvature_view, flat};
use milkglass::internals::session::run::Session;
use milkglass::internals::view::atomic_file::ready;
use milkglass::internals::view::film::is_gif;
use milkglass::internals::view::picture::{check, encode};

/// Arguments of `render`.
#[derive(Args)]
#[command(after_help = "Example: milkglass render lotus -o lotus.png --size 800x600 --set camera.exposure=3")]
pub struct Arguments {
    #[command(flatten)]
    picture: PictureArguments,
    #[command(flatten)]
    limit: super::walk::LimitArgument,
    /// The picture: `.png` (exposed, toned, sRGB) or `.exr` (linear); of several frames also `.gif`.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Add layers to an `.exr`: irradiance, radiosity, normal, shadows, error_estimate, depth, object, triangle,
    /// links.
    #[arg(long)]
    aov: bool,
    /// Show something other than light.
    #[arg(long, value_enum, conflicts_with_all = ["aov", "turntable"])]
    view: Option<View>,
    /// Render these frames, both ends included, each to its own file: `-o frame-%04d.png`; or all to one:
    /// `-o film.gif`. Frames do not depend on one another.
    #[arg(long, value_name = "A..B", conflicts_with_all = ["view", "frame", "times", "turntable"],
          allow_hyphen_values = true)]
    frames: Option<String>,
    /// With --frames or --turntable: skip frames whose file exists.
    #[arg(long)]
    skip_existing: bool,
    /// The pixel for `--view clusters`, from the upper left.
    #[arg(long, value_name = "X,Y", requires = "view")]
    pick: Option<String>,
    /// Print each stage's time, and the wall time beside them.
    #[arg(long, conflicts_with = "turntable")]
    times: bool,
}

impl Arguments {
    /// Whether layers can be written.
    fn check_layers(&self) -> Result<()> {
        if !self.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
            let found = self.output.display();
            return Err(Input::new("only OpenEXR has layers").key("--aov").found(found).expected("-o FILE.exr").into());
        }
        self.picture.run.options().carries("--aov")
    }

    /// What the frame computes; what is shown instead of light needs other options.
    fn options(&self) -> Result<Options> {
        let mut options = self.picture.run.options();
        if self.aov {
            options = options.with_layers();
        }
        let clustered = matches!(self.view, Some(View::Clusters));
        if clustered != self.pick.is_some() {
            let fault = Input::new("--view clusters and --pick X,Y go together").key("--pick");
            return Err(fault.expected("both or neither").into());
        }
        if matches!(self.view, Some(View::Curvature)) {
            options.transport = ShadingMethod::Cdrf;
        }
        if clustered {
            if options.transport != ShadingMethod::Hierarchy {
                let found = "another --transport";
                return Err(Input::new("only the hierarchy has links").key("--view clusters").found(found).into());
            }
            options.mode = Mode::Keep;
        }
        Ok(options)
    }
}

/// The scene of a picture, how it is rendered, and the picture's size.
#[derive(Args)]
pub struct PictureArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    #[command(flatten)]
    pub bare: BareArguments,
    #[command(flatten)]
    pub run: RunArguments,
    /// Width and height in pixels; overrides the scene's.
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
}

impl PictureArguments {
    /// Width and height in pixels, if given.
    pub fn size(&self) -> Result<Option<[u32; 2]>> {
        self.size.as_deref().map(parse_size).transpose()
    }

    /// The scene of each frame.
    pub fn subject(&self) -> Result<Subject> {
        self.bare.subject(self.run.of(&self.scene), self.size()?)
    }
}

/// What can be shown instead of light.
#[derive(Clone, Copy, ValueEnum)]
enum View {
    /// The clusters that light the point at `--pick`, for the first group of channels (see `plan`): blue the largest,
    /// red the smallest, white the receivers, grey triangles that emit nothing.
    Clusters,
    /// The curvature of the surface (kappa of `--transport cdrf`): red high, blue low.
    Curvature,
}

/// Renders and writes the picture.
pub fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    arguments.limit.hold();
    let film = is_gif(&arguments.output) && arguments.frames.is_some() | arguments.picture.bare.turns().is_some();
    if !film {
        check(&arguments.output)?;
    }
    let aov = arguments.aov;
    if aov {
        arguments.check_layers()?;
    }
    let around = arguments.picture.bare.turns().map(|turns| format!("0..{}", turns - 1));
    let range = arguments.frames.clone().or(around);
    if range.is_none() || film {
        ready([("-o", Some(&arguments.output))])?;
    }
    if arguments.skip_existing && (film || range.is_none()) {
        let fault = Input::new("only for frames that have a file each").key("--skip-existing");
        let found = arguments.output.display();
        return Err(fault.found(found).expected("--frames or --turntable, and -o NAME-%04d.png").into());
    }
    let frames = range.as_deref().map(|text| sequence::parse(text, &arguments.output)).transpose()?;
    let size = arguments.picture.size()?;
    let pick = arguments.pick.as_deref().map(parse_pick).transpose()?;
    let device = phase("opening the device", || arguments.picture.run.device.open(validation()))?;
    let options = arguments.options()?;
    let subject = arguments.picture.subject()?;
    if let Some(frames) = frames {
        let (scenes, output, skip) = (&subject, &arguments.output, arguments.skip_existing);
        let job = sequence::Job { scenes, frames, size, options, output, aov, skip };
        return job.run(device.as_ref());
    }
    let mut scene = phase("loading the scene", || subject.load())?;
    scene.camera = scene.camera.clone().sized(size.unwrap_or(scene.camera.size))?;
    let mut session = phase("opening the session", || open_session(&scene, device.as_ref(), options))?;
    tell_long_work(&session);
    let lit = pick.is_none() && arguments.view.is_none();
    let foretold = if lit { phase(FRAMES, || foretell(&mut session))? } else { None };
    let mut times = foretold.clone().unwrap_or_default();
    let change = if foretold.is_some() { Change::VIEW } else { Change::EVERYTHING };
    // Layers and what is shown instead of light belong to rays through the pixels' centres.
    let first = if lit && !aov { run_first_sample } else { run_frame };
    times.extend(phase(FRAMES, || first(&mut session, change))?);
    if !lit {
        if arguments.times {
            super::solve::print_times(&mut session, &times)?;
        }
        return save_view(&mut session, device.as_ref(), pick, &arguments.output);
    }
    let samples = Samples::new(&session, foretold.is_some());
    times.extend(phase(FRAMES, || sequence::shoot(&mut session, aov, &arguments.output, samples))?);
    if arguments.times {
        super::solve::print_times(&mut session, &times)?;
    }
    check_messages(device.as_ref())?;
    let place = device.as_ref().map_or("the CPU", |device| device.name());
    let seconds = start.elapsed().as_secs_f64();
    let (file, [width, height]) = (arguments.output.display(), scene.camera.size);
    let camera = &session.scene().camera;
    let exposed = if camera.metered { format!(", exposure {:.3}", camera.exposure) } else { String::new() };
    tell!("{file}: {width} x {height}{exposed}, on {place}, {seconds:.1} s");
    if options.transport == ShadingMethod::Cdrf { tell_flat(&mut session) } else { Ok(()) }
}

/// Saves and explains what is shown instead of light: the clusters that light a pixel, or the curvature.
fn save_view(session: &mut Session, device: Option<&Device>, pick: Option<[u32; 2]>, output: &Path) -> Result<()> {
    if let Some(pick) = pick {
        let (picture, emitters) = clusters(session, pick)?;
        check_messages(device)?;
        picture.save(output)?;
        return print_levels(&emitters);
    }
    let (picture, curvature_view) = curvature_view(session)?;
    check_messages(device)?;
    picture.save(output)?;
    print_curvature(&curvature_view, session.scene().unit_mm)
}

/// Tells where the CDRF serves the scene badly.
fn tell_flat(session: &mut Session) -> Result<()> {
    let share = flat(session)?;
    if share > 0.25 {
        tell!(
            "note: sigma_0 kappa is above 1 on {:.0} % of the vertices, where the CDRF hardly depends on the light: \
             smaller material.sigma_0 (`fit-cdrf`), or --transport hierarchy",
            100.0 * share
        );
    }
    Ok(())
}

/// Prints the number of emitters per level.
fn print_levels(emitters: &Emitters) -> Result<()> {
    print(&table(["level", "emitters", "triangles in them", "colour"], level_rows(emitters)))
}

/// The level, its emitters, the triangles in them and its colour, by level.
pub fn level_rows(emitters: &Emitters) -> Vec<Vec<String>> {
    let row = |(&level, &(clusters, triangles)): (&usize, &(usize, usize))| {
        vec![level.to_string(), clusters.to_string(), triangles.to_string(), hex(color(emitters, level))]
    };
    emitters.levels.iter().map(row).collect()
}

/// A linear colour as `#rrggbb`.
fn hex(color: [f32; 3]) -> String {
    let [r, g, b] = color.map(|x| (encode(x.into()) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Five values from the low to the high end of a scale of colours, with their colours.
pub fn ramp_rows(ramp: &CurvatureView) -> Vec<(f64, String)> {
    let [low, high] = ramp.ends;
    let row = |k: i32| {
        let value = if low > 0.0 { low * (high / low).powf(f64::from(k) / 4.0) } else { high * f64::from(k) / 4.0 };
        (value, hex(ramp.color(value)))
    };
    (0..5).map(row).collect()
}

/// Rows of the scale of colours: kappa in 1/mm, its inverse in mm, and the colour.
pub fn curvature_rows(view: &CurvatureView, unit_mm: f64) -> Vec<Vec<String>> {
    let row = |(kappa, color): (f64, String)| {
        let radius = if kappa > 0.0 { format!("{:.3e}", unit_mm / kappa) } else { "flat".into() };
        vec![format!("{:.3e}", kappa / unit_mm), radius, color]
    };
    ramp_rows(view).into_iter().map(row).collect()
}

/// Prints the colour scale of a curvature picture.
fn print_curvature(curvature_view: &CurvatureView, unit_mm: f64) -> Result<()> {
    let rows = curvature_rows(curvature_view, unit_mm);
    print(&table(["kappa, 1/mm", "1 / kappa, mm", "colour"], rows))?;
    let [median, most] = curvature_view.apart.map(|share| 100.0 * share);
    print(&format!("a cubic fit differs by {median:.1} % of the sum of both (median), {most:.0} % (95th percentile)\n"))
}

/// Parses `120,80`, counted from the upper left.
fn parse_pick(text: &str) -> Result<[u32; 2]> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?])).ok_or_else(|| {
        Input::new("not a pixel").key("--pick").found(text).expected("X,Y, counted from the upper left").into()
    })
}

/// Parses `800x600`, each side from 1 to 16384.
pub fn parse_size(text: &str) -> Result<[u32; 2]> {
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
