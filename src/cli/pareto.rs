//! `milkglass pareto`: error against run time.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

use super::replace::ReplaceArgument;
use super::{DeviceArgument, SceneArguments, check_messages, print, validation, write};
use milkglass::Session;
use milkglass::error::{Input, Result};
use milkglass::internals::pipeline::plan::{Goal, Mode, Options, ShadingMethod};
use milkglass::internals::state::Scheme;
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::pareto::{
    Against, Bench, Leaves, Lighting, METHODS, Method, Origin, Point, Ratio, Run, Settings, Sweep, csv, mark, ratios,
    svg, sweep,
};
use milkglass::measure::table::{Column, Table};

/// Arguments of `pareto`.
#[derive(Args)]
#[command(after_help = "Example: milkglass pareto bunny.obj --csv bunny.csv --svg bunny.svg\n         \
                        milkglass pareto sphere --quick --methods links,brute")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    device: DeviceArgument,
    #[command(flatten)]
    replace: ReplaceArgument,
    /// Measure replaced kernels even if their values are not those of the reference, as those of another oracle or
    /// rule: then their points are called unproved.
    #[arg(long, requires = "replace")]
    unchecked: bool,
    /// Compare with a random walk as well: `walk`, `walk:SECONDS`, or a CSV file that `solve --transport walk` wrote.
    #[arg(long, value_name = "TRUTH")]
    truth: Option<String>,
    #[command(flatten)]
    limit: super::walk::LimitArgument,
    /// Also write every point to this file.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also draw error against time in this file.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// The methods, separated by commas [default: all].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Vec<String>,
    /// Number of random faces at which errors are measured [default: 500, with --quick 100].
    #[arg(long, value_name = "FACES", allow_negative_numbers = true)]
    samples: Option<NonZeroUsize>,
    /// Seed for choosing those faces.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Timed frames per point, after one that warms up; at least 5.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(5..=1000))]
    repeat: u32,
    /// Skip points that would take longer, in seconds [default: 60, with --quick 5].
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    budget: Option<f64>,
    /// Only the two coarsest settings of each method, fewer samples and a smaller budget.
    #[arg(long)]
    quick: bool,
}

/// Above this, a point's time says more about other load on the machine than about the method.
const BUSY: f64 = 1.3;

/// Measures, prints, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut settings = settings(arguments)?;
    arguments.limit.hold();
    for (option, path, ending) in [("--csv", &arguments.csv, "csv"), ("--svg", &arguments.svg, "svg")] {
        if let Some(path) = path {
            check(option, path, ending)?;
        }
    }
    ready([("--csv", arguments.csv.as_ref()), ("--svg", arguments.svg.as_ref())])?;
    let mut scene = arguments.scene.load()?;
    if std::mem::take(&mut scene.transport.subdivide) > 0 {
        tell!("transport.subdivide = 0 here: errors are those of the mesh's own triangles");
    }
    let device = arguments.device.open(validation())?;
    // Setups that together use the kernels of all methods; a picture alone does not.
    let mut links = scene.clone();
    links.transport.scheme = Scheme::Links;
    let radiosity = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut setups = vec![
        (&scene, Options::default()),
        (&scene, Options { mode: Mode::Render, ..radiosity }),
        (&links, radiosity),
        (&scene, Options { transport: ShadingMethod::Brute, ..radiosity }),
    ];
    let diffusion = Options { transport: ShadingMethod::Diffusion, ..radiosity };
    if Session::new(&scene, None, diffusion).is_ok() {
        setups.push((&scene, diffusion));
    }
    let own = arguments.replace.on(device.as_ref(), &setups, arguments.unchecked)?;
    let bench = Bench { scene: &scene, device: device.as_ref() };
    let walk = |from: &String| super::walk::truth(from, &scene, device.as_ref());
    settings.truth = arguments.truth.as_ref().map(walk).transpose()?;
    let mut found = sweep(&bench, &settings)?;
    if let Some((own, proved)) = &own {
        let after = sweep(&Bench { scene: &scene, device: Some(own) }, &settings)?;
        print(&replaced(&found, &after))?;
        found = found.beside(after, if *proved { "replaced" } else { "unproved" });
    }
    check_messages(device.as_ref())?;
    let origin = Origin::new(&scene, device.as_ref(), settings.repeat);
    print(&text(&found, &origin))?;
    arguments.csv.iter().try_for_each(|path| write(path, csv(&found, &origin)?))?;
    arguments.svg.iter().try_for_each(|path| write(path, svg(&found, &origin)?))
}

/// Wall times with the built-in shaders and with the user's, point by point.
fn replaced(before: &Sweep, after: &Sweep) -> String {
    let pairs = before.points.iter().zip(&after.points);
    let rows: Vec<(&Point, [f64; 2])> = pairs
        .filter_map(|(point, other)| {
            let (before, after) = (point.run.as_ref().ok()?, other.run.as_ref().ok()?);
            Some((point, [before.wall_ms, after.wall_ms]))
        })
        .collect();
    let columns: [Column<'_, (&Point, [f64; 2])>; 6] = [
        ("", "", &|(point, _)| point.lighting.name().into()),
        ("method", "", &|(point, _)| point.method.name.into()),
        ("setting", "", &|(point, _)| point.setting()),
        ("built-in ms", "", &|(_, [before, _])| format!("{before:.2}")),
        ("replaced ms", "", &|(_, [_, after])| format!("{after:.2}")),
        ("ratio", "", &|(_, [before, after])| format!("{:.3}", after / before)),
    ];
    let table = Table::of(&rows, &columns).text();
    format!("one sweep after the other\n{table}\n")
}

/// Returns an error if the name's extension is that of another format.
fn check(option: &str, path: &Path, ending: &str) -> Result<()> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending)) {
        return Ok(());
    }
    let fault = Input::new("the name says the format").key(option).found(path.display());
    Err(fault.expected(format!("a name that ends in .{ending}")).into())
}

fn settings(arguments: &Arguments) -> Result<Settings> {
    let quick = arguments.quick;
    let budget = arguments.budget.unwrap_or(if quick { 5.0 } else { 60.0 });
    if !(budget.is_finite() && budget > 0.0) {
        return Err(Input::new("out of range").key("--budget").found(budget).expected("seconds, above 0").into());
    }
    let mut methods: Vec<&'static Method> = Vec::new();
    for name in &arguments.methods {
        let known = METHODS.iter().find(|method| method.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
            let names: Vec<_> = METHODS.iter().map(|method| method.name).collect();
            Input::new("unknown method").key("--methods").found(name).expected(names.join(", "))
        })?;
        if !methods.iter().any(|method| method.name == known.name) {
            methods.push(known);
        }
    }
    Ok(Settings {
        methods: if methods.is_empty() { METHODS.iter().collect() } else { methods },
        values: if quick { 2 } else { usize::MAX },
        repeat: arguments.repeat as usize,
        samples: arguments.samples.map_or(if quick { 100 } else { 500 }, NonZeroUsize::get),
        seed: arguments.seed,
        budget,
        truth: None,
    })
}

/// The report as text.
fn text(found: &Sweep, origin: &Origin) -> String {
    let Origin { device, driver, scene, faces, extent_mm, material, repeat } = origin;
    let mut text = format!(
        "{scene}: {faces} faces, {extent_mm} mm across, {material}\non {device}, {driver}\n\n\
         times: median of {repeat} frames after a first one, milliseconds; `device` by its timestamps, `wall` from \
         call to result,\n       spread from the fastest to the slowest frame as a share of the median, `busy` the time \
         of a fixed small job beside it\n       as a multiple of its fastest\n\
         errors: of B at {} seeded faces, worst channel; `own` against brute force in f64 over the method's own leaf \
         sums, `total`\n        against the area integral over the same faces; `leaves` is the L2 of those leaf sums \
         against it\n        (midpoint sums without clusters: {:.1e}); * on the front of wall time and L2; diffusion is \
         another model: `own`\n        against its own solution on the CPU at a tenth of its finest tolerance\n\n",
        found.samples, found.midpoint.l2,
    );
    if let Some(walk) = &found.truth {
        let noise = found.points.iter().find_map(|point| Some(point.run.as_ref().ok()?.truth?.noise));
        text += &format!(
            "truth:  {walk}; L2 of means over patches, per channel, without its noise of {:.1e}\n\n",
            noise.unwrap_or(f64::NAN)
        );
    }
    for lighting in Lighting::ALL {
        text += &points(found, lighting);
        text.push('\n');
    }
    let busy = Lighting::ALL.iter().flat_map(|&light| found.measured(light)).filter(|(_, run)| run.busy > BUSY).count();
    if busy > 0 {
        text +=
            &format!("busy: {busy} points were timed while something else slowed the device; repeat them to compare\n");
    }
    text += &left_out(found);
    text + "\n" + &ratio_table(found)
}

/// The points that were not measured and why; settings with the same reason share a line.
fn left_out(found: &Sweep) -> String {
    let mut lines: Vec<(String, String, &str)> = Vec::new();
    for point in &found.points {
        let Err(why) = &point.run else { continue };
        let about = format!("{}, {}", point.method.name, point.lighting.name());
        match lines.iter_mut().find(|line| line.0 == about && line.2 == why) {
            Some((_, settings, _)) => *settings += &format!(" {}", point.value),
            None => lines.push((about, point.setting(), why)),
        }
    }
    let line = |(about, settings, why): &(String, String, &str)| {
        let gap = if settings.is_empty() { "" } else { ", " };
        format!("n/a: {about}{gap}{settings}: {why}\n")
    };
    lines.iter().map(line).collect()
}

/// The points under one lighting.
fn points(found: &Sweep, lighting: Lighting) -> String {
    let fronts = [Against::Own, Against::Total].map(|against| mark(found, against));
    let all = found.points.iter().enumerate().filter(|(_, point)| point.lighting == lighting);
    let rows: Vec<(usize, &Point, &Run)> =
        all.filter_map(|(k, point)| Some((k, point, point.run.as_ref().ok()?))).collect();
    let error = |x: f64| if x.is_nan() { "-".to_string() } else { format!("{x:.1e}") };
    let star = |front: bool| if front { "*" } else { "" }.to_string();
    let exact = |point: &Point| point.method.leaves == Leaves::Exact || found.midpoint.l2 <= 0.0;
    let truth = |run: &Run, channel: usize| run.truth.map_or_else(String::new, |truth| error(truth.l2[channel]));
    let columns: [Column<'_, (usize, &Point, &Run)>; 19] = [
        (lighting.name(), "", &|(_, point, _)| point.method.name.into()),
        ("setting", "", &|(_, point, _)| point.setting()),
        ("device", "", &|(.., run)| run.device_ms.map_or("n/a".into(), |ms| format!("{ms:.2}"))),
        ("wall", "", &|(.., run)| format!("{:.2}", run.wall_ms)),
        ("spread", "", &|(.., run)| format!("{:.0} %", 100.0 * (run.range_ms[1] - run.range_ms[0]) / run.wall_ms)),
        ("busy", "", &|(.., run)| format!("{:.1}", run.busy)),
        ("own L2", "", &|(.., run)| error(run.own.l2)),
        ("p99", "", &|(.., run)| error(run.own.p99)),
        ("max", "", &|(.., run)| error(run.own.max)),
        ("", "", &|(k, ..)| star(fronts[0][*k])),
        ("leaves", "", &|(_, point, _)| if exact(point) { "0".into() } else { error(found.midpoint.l2) }),
        ("total L2", "", &|(.., run)| error(run.total.l2)),
        ("p99", "", &|(.., run)| error(run.total.p99)),
        ("max", "", &|(.., run)| error(run.total.max)),
        ("", "", &|(k, ..)| star(fronts[1][*k])),
        ("links/face", "", &|(.., run)| run.links_per_face.map_or("-".into(), |links| format!("{links:.1}"))),
        ("truth r", "", &|(.., run)| truth(run, 0)),
        ("g", "", &|(.., run)| truth(run, 1)),
        ("b", "", &|(.., run)| truth(run, 2)),
    ];
    let count = if found.truth.is_some() { columns.len() } else { columns.len() - 3 };
    Table::of(&rows, &columns[..count]).text()
}

/// Times at equal error.
fn ratio_table(found: &Sweep) -> String {
    let base = &METHODS[0];
    format!(
        "wall time at equal error, and its ratio to that of {} (above 1: slower); read between points, never beyond\n{}",
        base.name,
        Ratio::table(&ratios(found, base)).text()
    )
}
