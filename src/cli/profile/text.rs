//! A profile as text: the frame, the device's rates, and a row for each stage.

use super::comparison::half;
use crate::cli::{size, table};
use milkglass::measure::profile::{Profile, Quantiles, Row};

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

pub(super) fn text(found: &Profile) -> String {
    let mut text = format!("{}, {}, on {}, {}\n", found.scene, frames(found), found.device, found.driver);
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
    text += "\ntimes in ms: median, half its 95 % interval, and from 10th to 90th percentile; wall: each step submitted and waited for by itself\n";
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
        "+-",
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
    text += &table(&header, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14], &rows);
    found.notes.iter().for_each(|note| text += &format!("\n{note}\n"));
    text
}

/// How many frames were timed, and how many of them count.
fn frames(found: &Profile) -> String {
    match found.samples.warm_up {
        0 => format!("{} frames", found.frames),
        first => format!("{} frames and {first} before them that warmed up", found.frames - first),
    }
}

fn cells(found: &Profile, row: &Row) -> Vec<String> {
    let [device, spread] = milliseconds(row.device);
    let plus = row.interval.as_ref().map_or_else(|| "-".into(), half);
    let steps = if row.steps > 1 { format!(" in {} steps", row.steps) } else { String::new() };
    let mut cells =
        vec![format!("{}{steps}", row.stage), device, plus, spread, milliseconds(Some(row.wall))[0].clone()];
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
