//! A profile as text: the frame, the device's rates, and a row for each stage.

use super::comparison::half;
use crate::cli::size;
use milkglass::measure::profile::{Profile, Quantiles, Row, Work};
use milkglass::measure::table::Table;

/// A median and its spread.
fn milliseconds(spread: Option<Quantiles>) -> [String; 2] {
    let show = |s: Quantiles| [format!("{:.3}", s.median), format!("{:.3}..{:.3}", s.low, s.high)];
    spread.map_or_else(|| ["-".into(), "-".into()], show)
}

/// A count in millions.
pub(super) fn millions(count: u64) -> String {
    let millions = count as f64 * 1e-6;
    if millions == 0.0 || millions >= 0.1 { format!("{millions:.1}") } else { format!("{millions:.4}") }
}

/// The changes in a stage's exact counts from one kernel to another, in a line.
pub(super) fn work_told(stage: &str, [before, after]: [Work; 2]) -> String {
    let arithmetic = |work: Work| {
        [("flop", work.flops), ("div", work.roots), ("exp", work.exps), ("instructions", work.instructions)]
    };
    let bytes = |work: Work| [("loads", work.loaded), ("stores", work.stored)];
    let in_millions = |count: u64| format!("{} M", millions(count));
    let mut all = Vec::new();
    for ((name, one), (_, two)) in arithmetic(before).into_iter().zip(arithmetic(after)) {
        all.push((name, one, two, [one, two].map(in_millions)));
    }
    for ((name, one), (_, two)) in bytes(before).into_iter().zip(bytes(after)) {
        all.push((name, one, two, [one, two].map(size)));
    }
    let (same, other): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, one, two, _)| one == two);
    let mut parts: Vec<String> =
        other.iter().map(|(name, one, two, [a, b])| format!("{name} {a} -> {b}{}", change(*one, *two))).collect();
    if other.is_empty() {
        let counts: Vec<String> = same.iter().map(|(name, .., [text, _])| format!("{name} {text}")).collect();
        return format!("work of {stage}: the same: {}\n", counts.join(", "));
    }
    if !same.is_empty() {
        let names: Vec<&str> = same.iter().map(|(name, ..)| *name).collect();
        parts.push(format!("{} unchanged", names.join(", ")));
    }
    format!("work of {stage}: {}\n", parts.join(", "))
}

/// A change in percent, or where that would round to none, its amount.
fn change(before: u64, after: u64) -> String {
    let percent = 100.0 * (after as f64 / before as f64 - 1.0);
    match percent {
        _ if before == 0 => String::new(),
        small if small.abs() < 0.05 => format!(" ({:+})", i128::from(after) - i128::from(before)),
        _ => format!(" ({percent:+.1} %)"),
    }
}

pub(super) fn text(found: &Profile) -> String {
    let mut text = format!("{}, {}, on {}, {}\n", found.scene, frames(found), found.device, found.driver);
    let [wall, spread] = milliseconds(Some(found.wall));
    text += &format!("a frame: {wall} ms from call to result ({spread})");
    if let Some(sum) = found.on_device {
        let [ms, spread] = milliseconds(Some(sum));
        text += &format!(", {ms} ms of stages on the device ({spread})");
    }
    let memory = if found.device == "cpu" { "bytes in buffers" } else { "device memory at most" };
    text += &format!("\n{memory}: {}\n", size(found.peak));
    if let Some(rates) = &found.rates {
        let (copy, fma, exp) = (rates.copy * 1e-9, rates.fma * 1e-9, rates.exp * 1e-9);
        text += &format!(
            "the device's rates, measured now: copy {copy:.2} GB/s (read and written), {fma:.2} G FMA/s, \
             {exp:.2} G exp/s\n"
        );
    }
    text += "\ntimes in ms: median, half its 95 % interval, and from 10th to 90th percentile; \
             wall: each step submitted and waited for by itself, of kernels\nthe device's time\n";
    if found.rows.iter().any(|row| row.work.is_some()) {
        text += "counted by the kernels themselves, in one more frame of the same result: \
                 read and written: each byte bound once, no more\nthan asked for; asked: by all loads and stores; \
                 in millions: additions and multiplications, divisions and roots, exponentials\nand the like; \
                 then shares of copy, FMA and exp rate\n";
    }
    text.push('\n');
    text += &stages(found).text();
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

/// The stages with their times, work, and shares of the device's rates.
fn stages(found: &Profile) -> Table {
    let work = |row: &Row, cell: &dyn Fn(Work) -> String| row.work.map_or_else(|| "-".into(), cell);
    let share = |row: &Row, k: usize| {
        found.shares(row)[k].map_or_else(|| "-".into(), |share| format!("{:.1} %", 100.0 * share))
    };
    let steps = |row: &Row| if row.steps > 1 { format!(" in {} steps", row.steps) } else { String::new() };
    Table::of(
        &found.rows,
        &[
            ("stage", "", &|row| format!("{}{}", row.stage, steps(row))),
            ("device", "", &|row| milliseconds(row.device)[0].clone()),
            ("+-", "", &|row| row.interval.as_ref().map_or_else(|| "-".into(), half)),
            ("spread", "", &|row| milliseconds(row.device)[1].clone()),
            ("wall", "", &|row| milliseconds(Some(row.wall))[0].clone()),
            ("dispatches", "", &|row| row.dispatches.to_string()),
            ("read", "", &|row| work(row, &|work| size(work.read))),
            ("written", "", &|row| work(row, &|work| size(work.written))),
            ("asked", "", &|row| work(row, &|work| size(work.loaded + work.stored))),
            ("flop", "", &|row| work(row, &|work| millions(work.flops))),
            ("div", "", &|row| work(row, &|work| millions(work.roots))),
            ("exp", "", &|row| work(row, &|work| millions(work.exps))),
            ("copy", "", &|row| share(row, 0)),
            ("fma", "", &|row| share(row, 1)),
            ("exp", "", &|row| share(row, 2)),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_counts_are_told_exactly() {
        let before = Work { flops: 479_800_000, exps: 15_500_000, loaded: 2 << 20, stored: 1 << 20, ..Work::default() };
        let told = |after: Work| work_told("gather", [before, after]);
        assert_eq!(
            told(Work { flops: 492_800_000, ..before }),
            "work of gather: flop 479.8 M -> 492.8 M (+2.7 %), div, exp, instructions, loads, stores unchanged\n"
        );
        // What rounds to nothing is told, too.
        assert_eq!(
            told(Work { flops: 479_800_012, roots: 3_000_000, loaded: 1 << 20, ..before }),
            "work of gather: flop 479.8 M -> 479.8 M (+12), div 0.0 M -> 3.0 M, loads 2048.0 KiB -> 1024.0 KiB \
             (-50.0 %), exp, instructions, stores unchanged\n"
        );
        assert_eq!(
            told(before),
            "work of gather: the same: flop 479.8 M, div 0.0 M, exp 15.5 M, instructions 0.0 M, loads 2048.0 KiB, \
             stores 1024.0 KiB\n"
        );
    }
}
