//! Times of several variants beside each other as text: medians, ratios, and what they show.

use std::path::Path;

use crate::cli::{print, table};
use milkglass::error::Result;
use milkglass::measure::profile::Settings;
use milkglass::measure::profile::file::Saved;
use milkglass::measure::rounds::{Forecast, Ratio, Samples};
use milkglass::measure::statistics::Interval;

/// How long the rounds after the first start are going to take, and which rows the budget leaves undecided.
pub(super) fn forecast(found: &Forecast, settings: &Settings) -> String {
    let Forecast { starts, each, seconds, fewest: [edited, others] } = *found;
    let mut text = match settings.until {
        None => format!("{starts} starts of {each} rounds, about {:.0} seconds", (starts as f64 * seconds).ceil()),
        Some(_) => {
            format!("starts of {each} rounds, about {:.0} seconds each, until --until is reached", seconds.ceil())
        }
    };
    text += &match edited {
        0 => format!("; a verdict takes {others} starts"),
        _ if others == 0 => format!("; a verdict takes {edited} starts"),
        _ => format!("; a verdict takes {edited} starts for the replaced stages, {others} for all other rows"),
    };
    // The first start that ends beyond the budget is the last.
    let last = (settings.enough / seconds.max(1e-9)).floor() + 1.0;
    if last < edited.max(others) as f64 {
        let which = match () {
            () if edited == 0 || last < edited.min(others) as f64 => "all rows",
            () if last < edited as f64 => "the replaced stages",
            () => "all but the replaced stages",
        };
        text += &format!(
            "; --budget ends it after about {last:.0} start{}, and {which} stay undecided",
            if last > 1.0 { "s" } else { "" }
        );
    }
    text
}

/// The ratios of variants of the same rounds; the edited stages are marked.
pub(super) fn told(samples: &Samples, ratios: &[Vec<Ratio>]) -> String {
    let mut text = rounds(samples);
    let Some((first, others)) = samples.variants.split_first() else { return text };
    for (other, rows) in others.iter().zip(ratios) {
        text += &format!("\n{}", rows_told([&first.name, &other.name], rows, &samples.edited, per_round(samples)));
        text += &unshared(&Samples::unshared(first, other));
    }
    let all = ratios.iter().flatten();
    let edited = all.clone().filter(|row| samples.edited.contains(&row.what)).count();
    let method = "of each start's median ratio (Hodges-Lehmann, signed ranks)";
    text += &format!("\n{}", meaning(method, edited, all.count() - edited));
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

/// Prints the ratios of two runs, each with its file, or a name in place of one; returns them.
pub(super) fn files((first, a): (&Saved, &Path), (second, b): (&Saved, &Path)) -> Result<Vec<Ratio>> {
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
    let seconds = per_round(&first.samples).max(per_round(&second.samples));
    text += &format!("\n{}", rows_told(["A", "B"], &rows, &[], seconds));
    if let (Some(one), Some(two)) = (first.samples.variants.first(), second.samples.variants.first()) {
        text += &unshared(&Samples::unshared(one, two));
    }
    text += &format!("\n{}", meaning("of medians (bootstrap)", 0, rows.len()));
    print(&text)?;
    Ok(rows)
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

/// Seconds that a round took, its share of the starts included.
fn per_round(samples: &Samples) -> f64 {
    samples.seconds / samples.orders.len().max(1) as f64
}

fn meaning(ratio: &str, edited: usize, others: usize) -> String {
    let families = match edited {
        0 => format!("the intervals of all {others} ratios hold together with 95 %"),
        1 if others == 0 => "its interval holds with 95 %".into(),
        1 => format!(
            "the interval of the replaced stage holds with 95 %, and so do those of the {others} other rows together"
        ),
        _ => format!(
            "the intervals of the {edited} replaced stages hold together with 95 %, and so do those of the {others} \
             others"
        ),
    };
    format!("ms: medians, and half their 95 % intervals; ratio: {ratio}; {families}\n")
}

/// A table of ratios, and what it shows: each edited stage by itself, then all other rows. `seconds` is the time of a
/// round.
fn rows_told(names: [&str; 2], rows: &[Ratio], edited: &[String], seconds: f64) -> String {
    let cells: Vec<Vec<String>> = rows.iter().map(|row| cells(row, edited)).collect();
    let [one, two] = names.map(|name| format!("{name} ms"));
    let header = ["stage", &one, "+-", &two, "+-", "ratio", "interval", "shows"];
    let mut text = table(header, cells) + "\n";
    let against = format!("{} against {}", names[1], names[0]);
    for stage in edited {
        let shown = match rows.iter().find(|row| row.what == *stage) {
            Some(row) => match row.finding() {
                Some(found) => {
                    let Interval { value, low, high } = row.ratio;
                    format!("{found} ({value:.3}, {low:.3}..{high:.3})")
                }
                None => verdict(&[row], seconds),
            },
            None => "undecided: it has no times here".into(),
        };
        text += &format!("{against}, {stage}: {shown}\n");
    }
    let others: Vec<&Ratio> = rows.iter().filter(|row| !edited.contains(&row.what)).collect();
    if others.is_empty() {
        return text;
    }
    let which = if edited.is_empty() { "" } else { ", all other rows" };
    text + &format!("{against}{which}: {}\n", verdict(&others, seconds))
}

/// What these rows show together. A row without an interval is undecided, however far its ratio is from 1.
fn verdict(rows: &[&Ratio], seconds: f64) -> String {
    let (decided, open): (Vec<&Ratio>, Vec<&Ratio>) = rows.iter().partition(|row| row.missing_rounds == 0);
    let found = |row: &&&Ratio| Some(format!("{} {} ({:.3})", row.what, row.finding()?, row.ratio.value));
    let found: Vec<String> = decided.iter().filter_map(|row| found(&row)).collect();
    let mut parts = vec![found.join(", ")];
    if let Some(whole) = decided.iter().rfind(|row| row.what == "stages").or(decided.last())
        && found.is_empty()
    {
        let percent = 100.0 * whole.hidden();
        parts =
            vec!["no difference shows".into(), format!("a change of {} by {percent:.1} % might be hidden", whole.what)];
    }
    if let Some(missing) = open.iter().map(|row| row.missing_rounds).max() {
        let names: Vec<&str> = open.iter().map(|row| row.what.as_str()).collect();
        let which = if decided.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
        let rounds = if missing == 1 { "1 more round".into() } else { format!("{missing} more rounds") };
        parts.push(format!("undecided{which}: about {rounds}, {}", lasting(missing as f64 * seconds)));
    }
    parts.retain(|part| !part.is_empty());
    parts.join("; ")
}

/// A time in whole seconds, at least one.
fn lasting(seconds: f64) -> String {
    let whole = seconds.ceil().max(1.0);
    format!("{whole:.0} second{}", if whole > 1.0 { "s" } else { "" })
}

fn cells(row: &Ratio, edited: &[String]) -> Vec<String> {
    let mark = if edited.contains(&row.what) { " (replaced)" } else { "" };
    let [before, after] = row.ms;
    let interval = match row.ratio.high.is_finite() {
        true => format!("{:.3}..{:.3}", row.ratio.low, row.ratio.high),
        false => "too few".into(),
    };
    let mut cells = vec![format!("{}{mark}", row.what)];
    for ms in [before, after] {
        cells.extend([format!("{:.3}", ms.value), half(&ms)]);
    }
    cells.extend([format!("{:.3}", row.ratio.value), interval, row.shows().to_string()]);
    cells
}

/// Half the width of an interval, in percent of the value.
pub(in crate::cli) fn half(interval: &Interval) -> String {
    let width = interval.half_width();
    if width.is_finite() { format!("{:.1} %", 100.0 * width) } else { "-".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(what: &str, value: f64, [low, high]: [f64; 2], missing_rounds: usize) -> Ratio {
        let ms = [1.0, value].map(|value| Interval { value, low: value, high: value });
        Ratio { what: what.into(), ms, ratio: Interval { value, low, high }, missing_rounds }
    }

    const OPEN: [f64; 2] = [0.0, f64::INFINITY];

    #[test]
    fn without_an_interval_nothing_is_decided() {
        let shown = |rows: &[Ratio]| verdict(&rows.iter().collect::<Vec<_>>(), 0.5);
        let slow = ratio("gather", 3.024, OPEN, 20);
        assert_eq!(shown(std::slice::from_ref(&slow)), "undecided: about 20 more rounds, 10 seconds");
        assert_eq!(shown(&[ratio("frame", 1.0, OPEN, 1)]), "undecided: about 1 more round, 1 second");
        let same = ratio("stages", 1.001, [0.99, 1.015], 0);
        let hidden = "no difference shows; a change of stages by 1.5 % might be hidden";
        assert_eq!(shown(&[same.clone(), ratio("frame", 1.0, [0.5, 2.0], 0)]), hidden);
        assert_eq!(
            shown(&[same.clone(), slow.clone()]),
            format!("{hidden}; undecided (gather): about 20 more rounds, 10 seconds")
        );
        let slower = ratio("link", 1.2, [1.1, 1.3], 0);
        assert_eq!(shown(&[slower, same]), "link slower (1.200)");
        let cells = cells(&slow, &["gather".into()]);
        assert_eq!(
            (cells[0].as_str(), &cells[5..]),
            ("gather (replaced)", &["3.024", "too few", "undecided"].map(String::from)[..])
        );
    }

    #[test]
    fn an_edited_stage_is_judged_first_and_by_itself() {
        let rows =
            [ratio("link", 1.0, OPEN, 20), ratio("gather", 3.024, [2.9, 3.1], 0), ratio("stages", 1.6, OPEN, 20)];
        let text = rows_told(["built-in", "replaced"], &rows, &["gather".into(), "pull".into()], 0.1);
        let lines: Vec<&str> = text.lines().skip(5).collect();
        assert_eq!(
            lines,
            [
                "replaced against built-in, gather: slower (3.024, 2.900..3.100)",
                "replaced against built-in, pull: undecided: it has no times here",
                "replaced against built-in, all other rows: undecided: about 20 more rounds, 2 seconds"
            ],
            "{text}"
        );
    }

    #[test]
    fn what_is_to_come_is_told() {
        let found = Forecast { starts: 10, each: 5, seconds: 2.05, fewest: [6, 10] };
        let with = |enough, until| forecast(&found, &Settings { enough, until, ..Settings::default() });
        let verdicts = "a verdict takes 6 starts for the replaced stages, 10 for all other rows";
        assert_eq!(with(f64::INFINITY, None), format!("10 starts of 5 rounds, about 21 seconds; {verdicts}"));
        for (budget, end) in [
            (15.0, "; --budget ends it after about 8 starts, and all but the replaced stages stay undecided"),
            (3.0, "; --budget ends it after about 2 starts, and all rows stay undecided"),
            (30.0, ""),
        ] {
            assert_eq!(with(budget, None), format!("10 starts of 5 rounds, about 21 seconds; {verdicts}{end}"));
        }
        let until = with(60.0, Some(0.01));
        assert_eq!(until, format!("starts of 5 rounds, about 3 seconds each, until --until is reached; {verdicts}"));
    }
}
