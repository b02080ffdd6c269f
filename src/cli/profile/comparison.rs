//! Times of several variants beside each other as text: medians, ratios, and what they show.

use std::path::Path;

use crate::cli::{print, table};
use milkglass::error::Result;
use milkglass::measure::profile::Settings;
use milkglass::measure::profile::file::Saved;
use milkglass::measure::rounds::{Ratio, Samples};
use milkglass::measure::statistics::Interval;

/// The ratios of variants of the same rounds; stages in `replaced` are marked.
pub(super) fn told(samples: &Samples, ratios: &[Vec<Ratio>], replaced: &[String]) -> String {
    let mut text = rounds(samples);
    let Some((first, others)) = samples.variants.split_first() else { return text };
    for (other, rows) in others.iter().zip(ratios) {
        text += &format!("\n{}", rows_told([&first.name, &other.name], rows, replaced));
        text += &unshared(&Samples::unshared(first, other));
    }
    text += &format!(
        "\n{}",
        meaning("of each start's median ratio (Hodges-Lehmann, signed ranks)", ratios.iter().map(Vec::len).sum())
    );
    samples.doubts().iter().for_each(|doubt| text += &format!("{doubt}\n"));
    text
}

/// How many rounds there were, in a line.
pub(in crate::cli) fn rounds(samples: &Samples) -> String {
    let all = samples.variants.first().map_or(0, |first| first.frame_ms.len());
    format!(
        "{all} rounds in {} starts and {:.1} s, in random order (seed {}), {}\n",
        all.div_ceil(samples.each.max(1)),
        samples.seconds,
        samples.seed,
        dropped(samples)
    )
}

/// A line if the budget ended before `--until` was reached.
pub(in crate::cli) fn unmet(samples: &Samples, settings: &Settings) -> String {
    let wide = settings.until.and_then(|until| samples.widest().filter(|(_, width)| *width > until));
    wide.map_or_else(String::new, |(what, width)| {
        let width = if width.is_finite() { format!("{:.1} %", 100.0 * width) } else { "without bound".into() };
        format!("time ran out before --until: the interval of {what} is still +-{width}; raise --budget\n")
    })
}

/// Prints the ratios of two runs; each has a file or a name of its own.
pub(super) fn files((first, a): (&Saved, &Path), (second, b): (&Saved, &Path)) -> Result<()> {
    first.same_subject(second, b)?;
    let mut text = String::new();
    for (name, path, saved) in [("A", a, first), ("B", b, second)] {
        let samples = &saved.samples;
        text += &format!(
            "{name}: {}: {}; {} rounds, {}\n",
            path.display(),
            saved.origin(),
            samples.orders.len(),
            dropped(samples)
        );
        samples.doubts().iter().for_each(|doubt| text += &format!("   {doubt}\n"));
    }
    text += "\nThese were timed at different times: what changed between the runs besides the program (load, clock, heat, \
             where memory and\ncode lie) is in every ratio. --against and --replace time in turn, and leave that out.\n";
    if first.device != second.device {
        text += "The devices differ.\n";
    }
    let rows = first.samples.against(&second.samples);
    text += &format!("\n{}", rows_told(["A", "B"], &rows, &[]));
    if let (Some(one), Some(two)) = (first.samples.variants.first(), second.samples.variants.first()) {
        text += &unshared(&Samples::unshared(one, two));
    }
    text += &format!("\n{}", meaning("of medians (bootstrap)", rows.len()));
    print(&text)
}

fn dropped(samples: &Samples) -> String {
    match samples.warm_up {
        0 => "none of them warming up".into(),
        count => format!("the first {count} of each start dropped as warming up"),
    }
}

fn unshared(stages: &[String]) -> String {
    if stages.is_empty() { String::new() } else { format!("only one of them has: {}\n", stages.join(", ")) }
}

fn meaning(ratio: &str, rows: usize) -> String {
    format!(
        "ms: medians, and half their 95 % intervals; ratio: {ratio}; the intervals of all {rows} ratios hold together \
         with 95 %\n"
    )
}

/// A table of ratios, and what it shows.
fn rows_told(names: [&str; 2], rows: &[Ratio], replaced: &[String]) -> String {
    let cells: Vec<Vec<String>> = rows.iter().map(|row| cells(row, replaced)).collect();
    let [one, two] = names.map(|name| format!("{name} ms"));
    let header = ["stage", &one, "+-", &two, "+-", "ratio", "interval", "shows"];
    let text = table(&header, &[1, 2, 3, 4, 5, 6], &cells);
    let found: Vec<String> = rows
        .iter()
        .filter_map(|row| Some(format!("{} {} ({:.3})", row.what, row.finding()?, row.ratio.value)))
        .collect();
    let whole = rows.iter().rfind(|row| row.what == "stages").or_else(|| rows.last());
    let hidden = whole.map(|row| (row, row.ratio.half_width())).filter(|(_, width)| width.is_finite());
    let hidden =
        hidden.map(|(row, width)| format!("; a change of {} by {:.1} % might be hidden", row.what, width * 100.0));
    match found.as_slice() {
        [] => format!("{text}\n{} against {}: no difference shows{}\n", names[1], names[0], hidden.unwrap_or_default()),
        found => format!("{text}\n{} against {}: {}\n", names[1], names[0], found.join(", ")),
    }
}

fn cells(row: &Ratio, replaced: &[String]) -> Vec<String> {
    let mark = if replaced.contains(&row.what) { " (replaced)" } else { "" };
    let [before, after] = row.ms;
    let interval = match row.ratio.high.is_finite() {
        true => format!("{:.3}..{:.3}", row.ratio.low, row.ratio.high),
        false => "too few".into(),
    };
    let mut cells = vec![format!("{}{mark}", row.what)];
    for ms in [before, after] {
        cells.extend([format!("{:.3}", ms.value), half(&ms)]);
    }
    cells.extend([format!("{:.3}", row.ratio.value), interval, row.finding().unwrap_or_default().to_string()]);
    cells
}

/// Half the width of an interval, in percent of the value.
pub(in crate::cli) fn half(interval: &Interval) -> String {
    let width = interval.half_width();
    if width.is_finite() { format!("{:.1} %", 100.0 * width) } else { "-".into() }
}
