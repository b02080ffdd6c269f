//! `milkglass pareto`: error against run time.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

use super::replace::ReplaceArgument;
use super::{DeviceArgument, SceneArguments, check_messages, print, table, validation};
use milkglass::Session;
use milkglass::error::{Input, Result};
use milkglass::internals::pipeline::plan::{Goal, Mode, Options, ShadingMethod};
use milkglass::internals::state::Scheme;
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::norms::Norms;
use milkglass::measure::pareto::{
    Against, Bench, Leaves, Lighting, METHODS, Method, Norm, Origin, Settings, Sweep, csv, extent_mm, mark, materials,
    ratios, svg, sweep,
};

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
    let own = arguments.replace.on(device.as_ref(), &setups)?;
    let bench = Bench { scene: &scene, device: device.as_ref() };
    let walk = |from: &String| super::walk::truth(from, &scene, device.as_ref());
    settings.truth = arguments.truth.as_ref().map(walk).transpose()?;
    let mut found = sweep(&bench, &settings)?;
    if own.is_some() {
        let after = sweep(&Bench { scene: &scene, device: own.as_ref() }, &settings)?;
        print(&replaced(&found, &after))?;
        found = after;
    }
    check_messages(device.as_ref())?;
    let origin = Origin {
        device: device.as_ref().map_or("cpu", |device| device.name()).to_string(),
        driver: device.as_ref().map_or("the f64 reference", |device| device.driver()).to_string(),
        scene: scene.name.clone(),
        faces: scene.objects.iter().map(|object| object.mesh.triangles.len()).sum(),
        extent_mm: extent_mm(&scene),
        material: materials(&scene),
        repeat: settings.repeat,
    };
    print(&text(&found, &origin))?;
    let write = |path: &Path, text: String| {
        write_atomically(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))
    };
    arguments.csv.iter().try_for_each(|path| write(path, csv(&found, &origin)?))?;
    arguments.svg.iter().try_for_each(|path| write(path, svg(&found, &origin)?))
}

/// Wall times with the built-in shaders and with the user's, point by point.
fn replaced(before: &Sweep, after: &Sweep) -> String {
    let pairs = before.points.iter().zip(&after.points);
    let rows: Vec<_> = pairs
        .filter_map(|(point, other)| {
            let (before, after) = (point.run.as_ref().ok()?, other.run.as_ref().ok()?);
            let cells =
                [point.lighting.name(), point.method.name].map(String::from).into_iter().chain([point.setting()]);
            let times = [before.wall_ms, after.wall_ms].map(|ms| format!("{ms:.2}"));
            Some(cells.chain(times).chain([format!("{:.3}", after.wall_ms / before.wall_ms)]).collect())
        })
        .collect();
    let header = ["", "method", "setting", "built-in ms", "replaced ms", "ratio"];
    format!("one sweep after the other; what follows is the replaced one's\n{}\n", table(&header, &[3, 4, 5], &rows))
}

/// An error if the name's extension is that of another format.
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
         call to result,\n       spread from the fastest to the slowest frame as a share of the median, `busy` a fixed small job beside it as \
         a\n       multiple of its fastest\n\
         errors: of B at {} seeded faces, worst channel; `own` against brute force in f64 over the method's own leaf \
         sums, `total`\n        against the area integral over the same faces; `leaves` is the L2 of the one against \
         the other\n        (midpoint sums without clusters: {:.1e}); * on the front of wall time and L2; diffusion is \
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
    let mut rows = Vec::new();
    for (k, point) in found.points.iter().enumerate().filter(|(_, point)| point.lighting == lighting) {
        let Ok(run) = &point.run else { continue };
        let errors = |norms: Norms, front: bool| {
            let star = if front { "*" } else { "" };
            let cell = |x: f64| if x.is_nan() { "-".to_string() } else { format!("{x:.1e}") };
            [norms.l2, norms.p99, norms.max].map(cell).into_iter().chain([star.to_string()])
        };
        let leaves = if point.method.leaves == Leaves::Exact { 0.0 } else { found.midpoint.l2 };
        let spread = (run.range_ms[1] - run.range_ms[0]) / run.wall_ms;
        let mut cells = vec![
            point.method.name.to_string(),
            point.setting(),
            run.device_ms.map_or("n/a".into(), |ms| format!("{ms:.2}")),
            format!("{:.2}", run.wall_ms),
            format!("{:.0} %", 100.0 * spread),
            format!("{:.1}", run.busy),
        ];
        cells.extend(errors(run.own, fronts[0][k]));
        cells.push(if leaves > 0.0 { format!("{leaves:.1e}") } else { "0".into() });
        cells.extend(errors(run.total, fronts[1][k]));
        cells.push(run.links_per_face.map_or("-".into(), |links| format!("{links:.1}")));
        cells.extend(run.truth.iter().flat_map(|truth| truth.l2.map(|l2| format!("{l2:.1e}"))));
        rows.push(cells);
    }
    let header = [
        lighting.name(),
        "setting",
        "device",
        "wall",
        "spread",
        "busy",
        "own L2",
        "p99",
        "max",
        "",
        "leaves",
        "total L2",
        "p99",
        "max",
        "",
        "links/face",
    ];
    let truth = if found.truth.is_some() { &["truth r", "g", "b"][..] } else { &[] };
    let right = [2, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13, 15, 16, 17, 18];
    table(&[&header, truth].concat(), &right[..12 + truth.len()], &rows)
}

/// Times at equal error.
fn ratio_table(found: &Sweep) -> String {
    let base = &METHODS[0];
    let rows: Vec<Vec<String>> = ratios(found, base)
        .iter()
        .map(|ratio| {
            let norm = match ratio.norm {
                Norm::L2 => "L2",
                Norm::P99 => "p99",
            };
            let error = format!("{norm} {}", ratio.against.name());
            let (light, method) = (ratio.lighting.name().to_string(), ratio.method.name.to_string());
            vec![light, error, method, ratio.cell(0), ratio.cell(1), ratio.cell(2)]
        })
        .collect();
    let about = format!(
        "wall time at equal error, and its ratio to that of {} (above 1: slower); read between points, never beyond\n",
        base.name
    );
    about + &table(&["", "error", "method", "1e-2", "1e-3", "1e-4"], &[3, 4, 5], &rows)
}
