//! The command line: one thin file per subcommand, and the arguments they share.

#[macro_use]
mod text;

mod bake;
mod bare;
mod compare;
mod compile;
mod conform;
mod device;
mod devices;
mod dump;
pub mod eval;
mod faces;
mod fit_cdrf;
mod flow;
mod gallery;
mod lists;
mod long_work;
mod memory;
mod pareto;
mod paths;
mod plan;
mod profile;
mod progress;
mod render;
mod replace;
mod report;
mod repro;
mod run_args;
mod samples;
mod sequence;
mod shader;
mod shell;
mod solve;
mod stop;
mod stress;
mod timing;
mod validity;
mod vary;
#[cfg(feature = "window")]
mod view;
mod walk;
mod watch;

use std::ffi::OsString;
use std::path::Path;

use clap::{Args, Parser, Subcommand};

use self::device::{DeviceArgument, check_messages, validation};
use self::memory::MemoryArgument;
use self::paths::{announce_pipe, any_path};
use self::run_args::OptionArguments;
pub use self::stop::{leave, remove_when_stopped};
use self::text::{now, print, size, table, write};
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::{Device, Timing};
use milkglass::internals::hierarchy::face_cluster::Method;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::measure::progress::observe;
use milkglass::scene::Scene;

#[derive(Parser)]
#[command(name = "milkglass", version, about = "Renders translucent things in Vulkan compute, proved against the CPU")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// The subcommands: what each does, its arguments, and the function that runs it.
macro_rules! commands {
    ($($(#[$meta:meta])* $name:ident($arguments:ty) => $run:path,)*) => {
        #[derive(Subcommand)]
        enum Command {
            $($(#[$meta])* $name($arguments),)*
        }

        impl Command {
            #[allow(unused_doc_comments, reason = "they are those of the variants")]
            fn run(&self) -> Result<()> {
                match self {
                    $($(#[$meta])* Self::$name(arguments) => $run(arguments),)*
                }
            }
        }
    };
}

commands! {
    /// Render a picture of a scene.
    Render(render::Arguments) => render::run,
    /// Show a scene in a window: turn it, light it, change its material.
    #[cfg(feature = "window")]
    View(view::Arguments) => view::run,
    /// Render meshes in materials, and write a page of the pictures with the commands that make them.
    Gallery(gallery::Arguments) => gallery::run,
    /// Solve light transport only: irradiance and radiosity of every face.
    Solve(solve::Arguments) => solve::run,
    /// Show what a scene needs: stages, buffers, and what is skipped and why.
    Plan(plan::Arguments) => plan::run,
    /// Time each stage, count its work, and compare that with what the device can do.
    Profile(profile::Arguments) => profile::run,
    /// Vary how the Vulkan API is used: time each variant against the default, once it computes the same.
    Vary(vary::Arguments) => vary::run,
    /// Compare every stage on a device with the CPU reference.
    Conform(conform::Arguments) => conform::run,
    /// Show what differs between two results of `conform`: of drivers, devices or commits.
    Compare(compare::Arguments) => compare::run,
    /// Write a stage of a fixture as files that repeat it elsewhere: SPIR-V, buffers, an AmberScript.
    Dump(dump::Arguments) => dump::run,
    /// Run what `dump` or `conform --dump` wrote on a device, and compare.
    Replay(repro::Arguments) => repro::run,
    /// Show what compilers of GPUs that are not here make of a scene's kernels: registers, spills, waves, cycles.
    Compile(compile::Arguments) => compile::run,
    /// Print a built-in shader's GLSL, as a starting point for your own: see `--replace`.
    Shader(shader::Arguments) => shader::run,
    /// Run the extreme cases: their fallbacks, whether results are finite, and the worst error against f64.
    Stress(stress::Arguments) => stress::run,
    /// Measure error against run time: methods, settings, and the Pareto front.
    Pareto(pareto::Arguments) => pareto::run,
    /// Measure everything and write a report page, with plots and pictures.
    Report(report::Arguments) => report::run,
    /// Evaluate form factors, profiles, layered slabs or the CDRF for each row of a CSV file.
    Eval(eval::Arguments) => eval::run,
    /// Bake a depth map from nested surfaces.
    BakeLayers(bake::Arguments) => bake::run,
    /// Fit the sigma_0 of `--transport cdrf` to a material: to the dipole, and to a random walk.
    FitCdrf(fit_cdrf::Arguments) => fit_cdrf::run,
    /// Show where shading by curvature is a good approximation of the dipole, and where it is not.
    Validity(validity::Arguments) => validity::run,
    /// List the Vulkan devices and the CPU back end.
    Devices(devices::Arguments) => devices::run,
    /// List the built-in scenes, or print one.
    Scenes(lists::Scenes) => lists::scenes,
    /// List the built-in materials.
    Materials(lists::Materials) => lists::materials,
    /// List the stages in the order of a frame: what each does, its source, what makes it run again.
    Stages(lists::Stages) => lists::stages,
    /// Print a completion script for a shell.
    Completions(shell::Completions) => shell::completions,
    /// Print the manual page, or write those of all commands to a folder.
    Man(shell::Man) => shell::man,
}

/// The scene, and overrides of its values.
#[derive(Args, Clone)]
struct SceneArguments {
    /// A scene file (TOML), a built-in scene's name, or a mesh (OBJ, PLY, STL, glTF).
    #[arg(value_parser = any_path())]
    scene: String,
    /// Change a value of the scene: `object.0.material.preset=ketchup`, `'light.0.intensity=[9,9,9]'`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// The frame, if values have keyframes.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    frame: f64,
    /// Play this animation of a glTF mesh; `milkglass scenes FILE` lists them.
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// Frames per second of the animation and of a GIF, 24 by default. An error where there is neither.
    #[arg(long, value_name = "N")]
    fps: Option<f64>,
    #[command(flatten)]
    memory: MemoryArgument,
}

impl SceneArguments {
    /// All settings: those of `--set`, then those of `--animation` and `--fps`.
    fn sets(&self) -> Vec<String> {
        let name = self.animation.as_ref().map(|name| format!("animation={}", toml::Value::String(name.clone())));
        let fps = self.fps.map(|fps| format!("fps={fps:?}"));
        self.sets.iter().cloned().chain(name).chain(fps).collect()
    }

    /// The arguments as words of a command line.
    fn words(&self) -> Vec<String> {
        let sets = self.sets.iter().flat_map(|set| ["--set".to_string(), set.clone()]);
        let animation = self.animation.iter().map(|name| format!("--animation={name}"));
        let rest = animation.chain(self.fps.iter().map(|fps| format!("--fps={fps}"))).chain(self.memory.words());
        [self.scene.clone(), format!("--frame={}", self.frame)].into_iter().chain(sets).chain(rest).collect()
    }

    /// Loads the scene and reports repairs to it.
    fn load(&self) -> Result<Scene> {
        let scene = self.at(self.frame)?;
        for line in scene.report.iter().chain(&scene.idle_fps()?) {
            tell!("{line}");
        }
        Ok(scene)
    }

    /// Checks that the values at a frame are valid; returns the picture's size.
    fn check(&self, frame: f64) -> Result<[u32; 2]> {
        Scene::check_at(&self.scene, &self.sets(), frame)
    }

    /// Loads another scene, at frame 0 without settings, with the same memory limit.
    fn other(&self, name: &str) -> Result<Scene> {
        Scene::load_from(name, &[], 0.0, &self.memory.files())
    }

    /// The scene at a frame, without a report.
    fn at(&self, frame: f64) -> Result<Scene> {
        finite(frame)?;
        announce_pipe(Path::new(&self.scene));
        Scene::load_from(&self.scene, &self.sets(), frame, &self.memory.files())
    }
}

/// Returns an error if a frame is not finite.
fn finite(frame: f64) -> Result<()> {
    if frame.is_finite() {
        return Ok(());
    }
    Err(Input::new("not a frame").key("--frame").found(frame).expected("a finite number").into())
}

/// Where and how to run.
#[derive(Args)]
struct RunArguments {
    #[command(flatten)]
    device: DeviceArgument,
    #[command(flatten)]
    option_args: OptionArguments,
}

impl RunArguments {
    fn of(&self, scene: &SceneArguments) -> SceneArguments {
        SceneArguments { sets: self.option_args.of(&scene.sets), ..scene.clone() }
    }

    fn options(&self) -> Options {
        self.option_args.options()
    }
}

/// Opens a session on this device; reports tree fallbacks and the like on standard error.
fn open_session(scene: &Scene, device: Option<&Device>, options: Options) -> Result<Session> {
    let mut session = Session::new(scene, device, options)?;
    greet(&mut session);
    Ok(session)
}

/// Reports on standard error what the user must know of a new session: tree fallbacks, deformations gone wrong, and the
/// like.
fn greet(session: &mut Session) {
    walk::watch(session);
    for (object, method) in session.prepared().methods.iter().enumerate() {
        let why = match method {
            Method::Merged => continue,
            Method::TooDeep => "merging neighbours made it too deep",
            Method::TooEntangled => "clusters have too many neighbours to merge",
        };
        tell!("tree of object {object}: {why}; split at medians instead");
    }
    sequence::warn_of_shape(session, "");
    session.divisions().iter().chain(&session.diffusion_doubts()).for_each(|line| tell!("{line}"));
    if let Some(why) = session.not_kept() {
        tell!("{why}");
    }
}

/// Runs a frame; reports once if links turn out to be too many to keep.
fn run_frame(session: &mut Session, change: Change) -> Result<Vec<Timing>> {
    run_by(session, |session| session.frame(change))
}

/// The same for the first frame of a picture, whose samples go on from it.
fn run_first_sample(session: &mut Session, change: Change) -> Result<Vec<Timing>> {
    run_by(session, |session| session.first_sample(change))
}

fn run_by(session: &mut Session, run: impl FnOnce(&mut Session) -> Result<Vec<Timing>>) -> Result<Vec<Timing>> {
    let before = session.not_kept().is_some();
    let times = run(session)?;
    if let Some(why) = session.not_kept().filter(|_| !before) {
        tell!("{why}");
    }
    walk::tell_walks(session);
    Ok(times)
}

/// Parses the arguments and runs the command they name.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Result<()> {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            let text = error.render().to_string();
            return Err(Input::new(text.trim_start_matches("error: ").trim_end()).into());
        }
        Err(error) => {
            print(&error.render().to_string())?;
            return Ok(());
        }
    };
    observe(Box::<progress::Bar>::default());
    cli.command.run()
}
