//! `milkglass solve`: light transport only, one row per face.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

use super::faces::{csv, ply};
use super::long_work::tell_long_work;
use super::{RunArguments, SceneArguments, check_messages, open_session, print, run_frame, table, validation, write};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Timing;
use milkglass::internals::layout::BufferId;
use milkglass::internals::phases::{phase, phases};
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Scheme;
use milkglass::internals::view::atomic_file::{is_device, ready};
use milkglass::measure::estimate::Quality;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::check;
use milkglass::scene::{Receivers, Transport};

/// Arguments of `solve`.
#[derive(Args)]
#[command(after_help = "Example: milkglass solve bunny.obj -o bunny.csv --verify 2000")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    #[command(flatten)]
    limit: super::walk::LimitArgument,
    /// `.csv`: one row per face; `.ply`: the mesh with radiosity as colours and properties.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Compare with brute force in f64 at this many random faces, and print the error per channel.
    #[arg(long, value_name = "FACES", allow_negative_numbers = true)]
    verify: Option<NonZeroUsize>,
    /// Seed for choosing the faces of `--verify`.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print each stage's time, and the wall time beside them.
    #[arg(long)]
    times: bool,
}

enum Format {
    Csv,
    Ply,
}

fn format(path: &Path) -> Result<Format> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("csv") => Ok(Format::Csv),
        Some("ply") => Ok(Format::Ply),
        None if is_device(path) => Ok(Format::Csv),
        _ => Err(Input::new("the name says the format")
            .key("-o")
            .found(path.display())
            .expected("a name that ends in .csv or .ply")
            .into()),
    }
}

/// The name of the phase of frames, with their stages.
pub const FRAMES: &str = "frames";

/// Solves, writes the output, and verifies if requested.
pub fn run(arguments: &Arguments) -> Result<()> {
    let output = match &arguments.output {
        Some(path) => Some((path, format(path)?)),
        None => None,
    };
    if output.is_none() && arguments.verify.is_none() && !arguments.times {
        return Err(Input::new("nothing to do").expected("-o FILE, --verify FACES or --times").into());
    }
    ready([("-o", arguments.output.as_ref())])?;
    arguments.run.options().carries("solve")?;
    arguments.limit.hold();
    let scene = phase("loading the scene", || arguments.scene.load())?;
    let device = phase("opening the device", || arguments.run.device.open(validation()))?;
    // Times alone are measured without an error estimate.
    let estimate = output.is_some() || arguments.verify.is_some();
    let options = Options { goal: Goal::Radiosity, estimate, ..arguments.run.options() };
    let mut session = phase("opening the session", || open_session(&scene, device.as_ref(), options))?;
    tell_long_work(&session);
    let times = phase(FRAMES, || run_frame(&mut session, Change::EVERYTHING))?;
    // Only a file needs every face.
    let faces = if output.is_some() { session.faces()? } else { Vec::new() };
    session.sharpen()?;
    tell_estimate(&mut session)?;
    check_messages(device.as_ref())?;
    if let Some((path, format)) = output {
        let text = match format {
            Format::Csv => csv(&session, &faces),
            Format::Ply => ply(&session, &faces),
        };
        write(path, text)?;
    }
    if arguments.times {
        print_times(&mut session, &times)?;
    }
    match arguments.verify {
        Some(count) => verify(arguments, count.get(), &mut session, &scene.transport),
        None => Ok(()),
    }
}

/// Compares with brute force, prints the errors, and fails if they are above the tolerance.
fn verify(arguments: &Arguments, count: usize, session: &mut Session, transport: &Transport) -> Result<()> {
    let checked = check(session, count, arguments.seed)?;
    let norms = checked.norms;
    let all = worst(&norms);
    let row = |name: &str, n: &milkglass::measure::norms::Norms| {
        vec![name.to_string(), format!("{:.3e}", n.l2), format!("{:.3e}", n.p99), format!("{:.3e}", n.max)]
    };
    let rows = [row("r", &norms[0]), row("g", &norms[1]), row("b", &norms[2]), row("worst", &all)];
    print(&table(["channel", "L2", "p99", "max"], rows.to_vec()))?;
    if let Some(Quality { covered, ratio, rank }) = checked.estimate {
        let share = 100.0 * covered;
        print(&format!(
            "the estimate is above the error at {share:.2} % of the faces; its p99 is {ratio:.1} times the error's; \
             rank correlation {rank:.2}\n"
        ))?;
    }
    if let Some(bound) = checked.bound {
        let [r, g, b] = bound.map(|l2| format!("{l2:.1e}"));
        print(&format!(
            "above: what is left of the equation of diffusion; the estimate of the error of B itself, L2: {r} {g} {b}\n"
        ))?;
    }
    // The tolerance applies to this L2, for the method that has a tolerance.
    let (tolerance, method) = (transport.tolerance, arguments.run.options().transport);
    let blocks = method == ShadingMethod::Hierarchy && transport.scheme == Scheme::Blocks;
    let solves = matches!(method, ShadingMethod::Diffusion | ShadingMethod::Auto);
    let bounded = blocks || (solves && transport.steps.is_none());
    if all.l2.is_nan() || bounded && all.l2 > tolerance {
        return Err(Error::Check(format!("L2 is {:.3e}, above transport.tolerance, {tolerance:e}", all.l2)));
    }
    Ok(())
}

/// Reports on standard error that the error estimate could not be refined, and is the larger one transported along with
/// the light; that triangles are too long to have one value each; that the estimate leaves out borders of shadows.
pub fn tell_estimate(session: &mut Session) -> Result<()> {
    if let Some(why) = session.blunt() {
        tell!("the error estimate is a looser one, since the second solve that sharpens it failed: {why}");
    }
    let long = session.left_long().into_iter().filter(|long| *long).count();
    if long > 0 {
        let faces = session.scene().transport.receivers == Receivers::Faces;
        let helps = if faces {
            "transport.receivers = \"auto\" divides them"
        } else {
            "a finer mesh, since the object deforms"
        };
        tell!(
            "{long} triangles are longer than the distance over which radiosity changes at edges, and have one value each, \
             that of their centroid; what helps: {helps}"
        );
    }
    let bordered = session.bordered()?;
    if bordered > 0 {
        tell!(
            "the error estimate leaves out the borders of shadows, which run through or along {bordered} of {} \
             triangles: transport.subdivide = 2 puts them in",
            session.state().sum(|object| if object.opaque { 0 } else { object.count.faces })
        );
    }
    Ok(())
}

/// Wall time beside the stages, by phase; `stages` is the time of all stages within the frames, ms.
fn phase_rows(stages: f64) -> Vec<Vec<String>> {
    let (phases, all) = phases();
    let known: f64 = phases.iter().map(|(_, ms)| ms).sum();
    let own = |(name, ms): (&'static str, f64)| match name {
        FRAMES => ("frames, without their stages", (ms - stages).max(0.0)),
        _ => (name, ms),
    };
    let rows = phases.into_iter().map(own).chain([("the rest", all - known), ("all, with the stages", all)]);
    rows.map(|(name, ms)| vec![name.to_string(), format!("{ms:.3}")]).collect()
}

/// Prints the time of each stage, summed over its steps in all frames, wall time by phase, and the numbers of entries
/// per block and of links.
pub fn print_times(session: &mut Session, times: &[Timing]) -> Result<()> {
    session.fetch(&[BufferId::spans, BufferId::runs])?;
    let mut rows: Vec<(String, usize, f64)> = Vec::new();
    for time in times {
        match rows.iter_mut().find(|(name, ..)| *name == time.name) {
            Some((_, steps, sum)) => (*steps, *sum) = (*steps + 1, *sum + time.milliseconds),
            None => rows.push((time.name.clone(), 1, time.milliseconds)),
        }
    }
    let (steps, total) = rows.iter().fold((0, 0.0), |(steps, sum), (_, count, ms)| (steps + count, sum + ms));
    rows.push(("total".into(), steps, total));
    let between = phase_rows(total);
    let row = |(name, steps, ms): (String, usize, f64)| vec![name, steps.to_string(), format!("{ms:.3}")];
    let rows: Vec<_> = rows.into_iter().map(row).collect();
    let data = &session.state().data;
    let links: u64 = data.spans.iter().map(|span| u64::from(span.links)).sum();
    print(&table(["stage", "steps", "ms"], rows))?;
    print(&table(["beside stages", "ms"], between))?;
    let count = |of: fn(&milkglass::internals::layout::Runs) -> u32| {
        session.state().runs().map(|run| u64::from(of(run))).sum::<u64>()
    };
    let lists = [
        ("expanded", count(|run| run.expanded)),
        ("direct", count(|run| run.direct)),
        ("area points", count(|run| run.area)),
        ("edge form", count(|run| run.edge)),
        ("dropped", count(|run| run.dropped)),
    ];
    if session.state().runs().next().is_some() {
        let per = |(name, n): &(&str, u64)| {
            format!("{:.1} {name}", *n as f64 / session.state().sum(|object| object.count.blocks) as f64)
        };
        print(&format!("a block: {}\n", lists.iter().map(per).collect::<Vec<_>>().join(", ")))?;
    }
    if links > 0 {
        print(&format!(
            "{links} links, {:.1} a triangle\n",
            links as f64 / session.state().sum(|object| object.count.faces) as f64
        ))?;
    }
    Ok(())
}
