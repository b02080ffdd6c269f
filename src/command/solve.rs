//! `milkglass solve`: light transport only, one row a face.

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;

use super::{RunArguments, SceneArguments, check_messages, open_session, print, table, validation};
use crate::error::{Input, Result};
use crate::gpu::Timing;
use crate::layout::Slot;
use crate::measure::estimate::Quality;
use crate::measure::norms::worst;
use crate::measure::reference::check;
use crate::render::plan::{Change, Goal, Options};
use crate::render::run::Session;
use crate::scene::Object;
use crate::view::picture::write_whole;

/// Arguments of `solve`.
#[derive(Args)]
#[command(after_help = "Example: milkglass solve bunny.obj -o bunny.csv --verify 2000")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    /// `.csv`: one row a face; `.ply`: the mesh with radiosity as colours and properties.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Compare with brute force in f64 at this many seeded faces, and print the error per channel.
    #[arg(long, value_name = "FACES", allow_negative_numbers = true)]
    verify: Option<NonZeroUsize>,
    /// Seed of the faces that `--verify` takes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print each stage's time.
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
        _ => Err(Input::new("the name says the format")
            .key("-o")
            .found(path.display())
            .expected("a name that ends in .csv or .ply")
            .into()),
    }
}

/// Solves, writes, and verifies if asked.
pub fn run(arguments: &Arguments) -> Result<()> {
    let output = match &arguments.output {
        Some(path) => Some((path, format(path)?)),
        None => None,
    };
    if output.is_none() && arguments.verify.is_none() && !arguments.times {
        return Err(Input::new("nothing to do").expected("-o FILE, --verify FACES or --times").into());
    }
    let scene = arguments.scene.load()?;
    let device = arguments.run.device.open(validation())?;
    // Times alone are those of a frame that estimates nothing.
    let estimate = output.is_some() || arguments.verify.is_some();
    let options = Options { goal: Goal::Radiosity, estimate, ..arguments.run.options() };
    let mut session = open_session(&scene, device.as_ref(), options)?;
    let times = session.frame(Change::EVERYTHING)?;
    session.fetch(&[Slot::clusters, Slot::irradiance, Slot::radiosity, Slot::estimate])?;
    check_messages(device.as_ref())?;
    if let Some((path, format)) = output {
        let text = match format {
            Format::Csv => csv(&session),
            Format::Ply => ply(&session),
        };
        write_whole(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))?;
    }
    if arguments.times {
        print_times(&mut session, &times)?;
    }
    if let Some(count) = arguments.verify {
        let checked = check(&mut session, count.get(), arguments.seed)?;
        let norms = checked.norms;
        let all = worst(&norms);
        let row = |name: &str, n: &crate::measure::norms::Norms| {
            vec![name.to_string(), format!("{:.3e}", n.l2), format!("{:.3e}", n.p99), format!("{:.3e}", n.max)]
        };
        let rows = [row("r", &norms[0]), row("g", &norms[1]), row("b", &norms[2]), row("worst", &all)];
        print(&table(&["channel", "L2", "p99", "max"], &[1, 2, 3], &rows))?;
        if let Some(Quality { covered, ratio, rank }) = checked.estimate {
            let share = 100.0 * covered;
            print(&format!(
                "the estimate is above the error at {share:.2} % of the faces; its p99 is {ratio:.1} times the error's; \
                 rank correlation {rank:.2}\n"
            ))?;
        }
    }
    Ok(())
}

/// Prints the time of each stage, its chunks together, and the number of links.
pub fn print_times(session: &mut Session, times: &[Timing]) -> Result<()> {
    session.fetch(&[Slot::spans, Slot::runs])?;
    let mut rows: Vec<(String, f64)> = Vec::new();
    for time in times {
        match rows.iter_mut().find(|(name, _)| *name == time.name) {
            Some((_, sum)) => *sum += time.milliseconds,
            None => rows.push((time.name.clone(), time.milliseconds)),
        }
    }
    let total: f64 = rows.iter().map(|(_, ms)| ms).sum();
    rows.push(("total".into(), total));
    let rows: Vec<_> = rows.into_iter().map(|(name, ms)| vec![name, format!("{ms:.3}")]).collect();
    let data = &session.state().data;
    let links: u64 = data.spans.iter().map(|span| u64::from(span.links)).sum();
    print(&table(&["stage", "ms"], &[1], &rows))?;
    let count = |of: fn(&crate::layout::Runs) -> u32| data.runs.iter().map(|run| u64::from(of(run))).sum::<u64>();
    let lists = [
        ("expanded", count(|run| run.expanded)),
        ("direct", count(|run| run.direct)),
        ("area points", count(|run| run.area)),
        ("edge form", count(|run| run.edge)),
        ("dropped", count(|run| run.dropped)),
    ];
    if !data.runs.is_empty() {
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

/// One row of results per input face, object after object, in the input's order: centroid, area, irradiance, radiosity, and the
/// estimate of its error where there is one.
struct Row {
    object: usize,
    input_face: u32,
    center: DVec3,
    area: f64,
    irradiance: [f64; 3],
    radiosity: [f64; 3],
    estimate: Option<[f64; 3]>,
    /// Numbers of the corners among the vertices of all objects.
    triangle: [u32; 3],
}

fn rows(session: &Session) -> Vec<Row> {
    let (data, units) = (&session.state().data, session.units());
    let light = |value: [f32; 3]| value.map(|x| f64::from(x) * units.light);
    let mut first = 0;
    let of_object = |(object, Object { mesh, .. }): (usize, &Object)| {
        let before = first;
        first += mesh.positions.len() as u32;
        let row = move |(of_mesh, face): (usize, usize)| {
            let triangle = mesh.triangles[of_mesh];
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            Row {
                object,
                input_face: mesh.input_face[of_mesh],
                center: (a + b + c) / 3.0,
                area: 0.5 * (b - a).cross(c - a).length(),
                irradiance: light(data.irradiance[face]),
                radiosity: light(data.radiosity[face]),
                estimate: data.estimate.get(face).copied().map(light),
                triangle: triangle.map(|v| v + before),
            }
        };
        session.prepared.places(object).into_iter().enumerate().map(row).collect::<Vec<_>>()
    };
    session.scene().objects.iter().enumerate().flat_map(of_object).collect()
}

fn csv(session: &Session) -> String {
    let mut text = String::from("face,cx,cy,cz,area,E_r,E_g,E_b,B_r,B_g,B_b,input_face");
    text += if session.state().method.estimate { ",err_r,err_g,err_b" } else { "" };
    let several = session.scene().objects.len() > 1;
    text += if several { ",object\n" } else { "\n" };
    for (face, row) in rows(session).iter().enumerate() {
        let (c, e, b) = (row.center, row.irradiance.map(digits), row.radiosity.map(digits));
        let _ = write!(text, "{face},{:.9e},{:.9e},{:.9e},{:.9e}", c.x, c.y, c.z, row.area);
        let _ = write!(text, ",{},{},{},{},{},{}", e[0], e[1], e[2], b[0], b[1], b[2]);
        let _ = write!(text, ",{}", row.input_face);
        for x in row.estimate.iter().flatten() {
            let _ = write!(text, ",{}", digits(*x));
        }
        if several {
            let _ = write!(text, ",{}", row.object);
        }
        text.push('\n');
    }
    text
}

/// An amount of light in the digits of an `f32`, also where it is beyond what one holds.
fn digits(x: f64) -> String {
    let single = x as f32;
    if single.is_normal() || x == 0.0 { format!("{single:e}") } else { format!("{x:.7e}") }
}

/// An amount of light as a PLY's floats hold it; what is beyond them is their largest.
fn single(x: f64) -> f32 {
    x.min(f32::MAX.into()) as f32
}

fn ply(session: &Session) -> String {
    let rows = rows(session);
    let objects = &session.scene().objects;
    let positions: Vec<DVec3> = objects.iter().flat_map(|object| &object.mesh.positions).copied().collect();

    // Vertex values are area-weighted means, as in the stage `average`; colours map the brightest to white.
    let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
    for row in &rows {
        for vertex in row.triangle {
            let (sum, area) = &mut sums[vertex as usize];
            *sum += row.area * DVec3::from_array(row.radiosity);
            *area += row.area;
        }
    }
    let values: Vec<DVec3> = sums.iter().map(|&(sum, area)| if area > 0.0 { sum / area } else { sum }).collect();
    let brightest = values.iter().map(|v| v.max_element()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n\
         element face {}\nproperty list uchar int vertex_indices\n\
         property float E_r\nproperty float E_g\nproperty float E_b\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n{}end_header\n",
        values.len(),
        rows.len(),
        if session.state().method.estimate {
            "property float err_r\nproperty float err_g\nproperty float err_b\n"
        } else {
            ""
        }
    );
    for (p, value) in positions.iter().zip(&values) {
        let byte = |x: f64| (crate::view::picture::encode(x / brightest) * 255.0 + 0.5) as u8;
        let b = value.to_array();
        let [red, green, blue] = b.map(byte);
        let _ = writeln!(
            text,
            "{} {} {} {red} {green} {blue} {} {} {}",
            p.x as f32,
            p.y as f32,
            p.z as f32,
            single(b[0]),
            single(b[1]),
            single(b[2])
        );
    }
    for row in &rows {
        let [a, b, c] = row.triangle;
        let _ = write!(text, "3 {a} {b} {c}");
        for x in row.irradiance.iter().chain(&row.radiosity).chain(row.estimate.iter().flatten()) {
            let _ = write!(text, " {}", single(*x));
        }
        text.push('\n');
    }
    text
}
