//! `milkglass profile`: time, work and memory traffic of each stage of a scene, compared with what the device can do.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::replace::ReplaceArgument;
use super::{RunArguments, SceneArguments, check_messages, print, size, table, validation};
use milkglass::error::Result;
use milkglass::internals::pipeline::plan::{Change, Mode};
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::profile::{Against, Profile, Quantiles, Row, Settings, against, profile};
use milkglass::measure::replace::stages;

/// Arguments of `profile`.
#[derive(Args)]
#[command(after_help = "Example: milkglass profile lotus --frames 21 --csv lotus.csv --trace lotus.json\n         \
                        milkglass profile bunny.obj --change light --mode render")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    #[command(flatten)]
    replace: ReplaceArgument,
    /// Timed frames, after those that warm up.
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// What changes before each frame.
    #[arg(long, value_enum, default_value_t)]
    change: ChangeArgument,
    /// Also write this CSV file, one row per stage.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write the whole profile to this JSON file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also write the timed frames for chrome://tracing or ui.perfetto.dev.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum ChangeArgument {
    /// Everything: a frame from scratch.
    #[default]
    Everything,
    /// The lights.
    Light,
    /// The coefficients of all materials.
    Material,
    /// The camera.
    View,
}

/// Measures, prints, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([
        ("--csv", arguments.csv.as_ref()),
        ("--json", arguments.json.as_ref()),
        ("--trace", arguments.trace.as_ref()),
    ])?;
    let scene = arguments.run.of(&arguments.scene).load()?;
    let device = arguments.run.device.open(validation())?;
    let change = match arguments.change {
        ChangeArgument::Everything => Change::EVERYTHING,
        ChangeArgument::Light => Change::LIGHT,
        ChangeArgument::Material => Change::MATERIAL,
        ChangeArgument::View => Change::VIEW,
    };
    let settings =
        Settings { options: arguments.run.options(), change, frames: arguments.frames as usize, ..Settings::default() };
    if settings.options.mode == Mode::Incremental && change == Change::EVERYTHING {
        tell!("mode incremental: nothing moves, so each frame only checks its links and makes no new ones");
    }
    let own = arguments.replace.on(device.as_ref(), &[(&scene, settings.options)])?;
    if let (Some(before), Some(after)) = (&device, &own) {
        print(&ratios(&against(&scene, [before, after], &settings)?, &stages(after)))?;
    }
    let device = own.or(device);
    let found = profile(&scene, device.as_ref(), &settings)?;
    check_messages(device.as_ref())?;
    print(&text(&found))?;
    let write = |path: &Path, text: String| {
        write_atomically(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))
    };
    if let Some(path) = &arguments.csv {
        write(path, found.csv()?)?;
    }
    if let Some(path) = &arguments.json {
        let mut value = found.json();
        value["replaced"] = serde_json::json!(arguments.replace.pairs());
        write(path, format!("{value:#}\n"))?;
    }
    if let Some(path) = &arguments.trace {
        write(path, format!("{}\n", found.trace()))?;
    }
    Ok(())
}

/// Times with the built-in kernels and with the replaced ones.
fn ratios(rows: &[Against], replaced: &[String]) -> String {
    let row = |row: &Against| {
        let [before, after] = row.times.map(|spread| milliseconds(Some(spread)));
        let ratio = format!("{:.3}", row.ratio);
        let mark = if replaced.contains(&row.what) { " (replaced)" } else { "" };
        vec![
            format!("{}{mark}", row.what),
            before[0].clone(),
            before[1].clone(),
            after[0].clone(),
            after[1].clone(),
            ratio,
        ]
    };
    let cells: Vec<_> = rows.iter().map(row).collect();
    let header = ["ms", "built-in", "spread", "replaced", "spread", "ratio"];
    let text = format!("built-in and replaced, frame by frame in turn\n{}\n", table(&header, &[1, 2, 3, 4, 5], &cells));
    // Stages that were not replaced show how much of a ratio is noise.
    let same =
        rows.iter().filter(|row| !replaced.contains(&row.what) && !["stages", "frame"].contains(&row.what.as_str()));
    let (low, high) =
        same.map(|row| row.ratio).fold((f64::INFINITY, 0.0), |(a, b), ratio| (f64::min(a, ratio), f64::max(b, ratio)));
    match low <= high {
        true => format!("{text}stages that are the same have ratios from {low:.3} to {high:.3}: so much is noise\n\n"),
        false => text,
    }
}

/// A median and its spread.
fn milliseconds(spread: Option<Quantiles>) -> [String; 2] {
    let show = |s: Quantiles| [format!("{:.3}", s.median), format!("{:.3}..{:.3}", s.low, s.high)];
    spread.map_or_else(|| ["-".into(), "-".into()], show)
}

/// A count in millions.
fn millions(count: u64) -> String {
    let millions = count as f64 * 1e-6;
    if millions == 0.0 || millions >= 0.1 { format!("{millions:.1}") } else { format!("{millions:.4}") }
}

fn text(found: &Profile) -> String {
    let mut text = format!("{}, {} frames, on {}, {}\n", found.scene, found.frames, found.device, found.driver);
    let [wall, spread] = milliseconds(Some(found.wall));
    text += &format!("a frame: {wall} ms from call to result ({spread})");
    if let Some(sum) = found.on_device {
        let [ms, spread] = milliseconds(Some(sum));
        text += &format!(", {ms} ms of stages on the device ({spread})");
    }
    let of = if found.device == "cpu" { "bytes in buffers" } else { "device memory at most" };
    text += &format!("\n{of}: {}\n", size(found.peak));
    if let Some(rates) = &found.rates {
        let (copy, fma, exp) = (rates.copy * 1e-9, rates.fma * 1e-9, rates.exp * 1e-9);
        text += &format!(
            "the device at best, measured now: copy {copy:.2} GB/s (read and written), {fma:.2} G FMA/s, {exp:.2} G exp/s\n"
        );
    }
    text +=
        "\ntimes in ms: median and from 10th to 90th percentile; wall: each step submitted and waited for by itself\n";
    if found.rows.iter().any(|row| row.work.is_some()) {
        text += "counted by the kernels themselves, in one more frame of the same bits: read and written: each byte bound once, \
                 no more\nthan asked for; asked: by all loads and stores; in millions: additions and multiplications, \
                 divisions and roots, exponentials\nand the like; then shares of copy, FMA and exp rate\n";
    }
    text.push('\n');
    let rows: Vec<Vec<String>> = found.rows.iter().map(|row| cells(found, row)).collect();
    let header = [
        "stage",
        "device",
        "spread",
        "wall",
        "dispatches",
        "read",
        "written",
        "asked",
        "flop",
        "div",
        "exp",
        "copy",
        "fma",
        "exp",
    ];
    text += &table(&header, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13], &rows);
    found.notes.iter().for_each(|note| text += &format!("\n{note}\n"));
    text
}

fn cells(found: &Profile, row: &Row) -> Vec<String> {
    let [device, spread] = milliseconds(row.device);
    let steps = if row.steps > 1 { format!(" in {} steps", row.steps) } else { String::new() };
    let mut cells = vec![format!("{}{steps}", row.stage), device, spread, milliseconds(Some(row.wall))[0].clone()];
    cells.push(row.dispatches.to_string());
    let work = row.work.map(|work| {
        let bytes = [work.read, work.written, work.loaded + work.stored].map(size);
        let counts = [work.flops, work.roots, work.exps].map(millions);
        [bytes, counts].concat()
    });
    cells.extend(work.unwrap_or_else(|| vec!["-".to_string(); 6]));
    let percent = |share: Option<f64>| share.map_or("-".into(), |share| format!("{:.1} %", 100.0 * share));
    cells.extend(found.shares(row).map(percent));
    cells
}
