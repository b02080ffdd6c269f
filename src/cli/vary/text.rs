//! What `vary` prints.

use crate::cli::profile::{half, rounds};
use crate::cli::table;
use milkglass::internals::gpu::{Choices, Device};
use milkglass::measure::rounds::Ratio;
use milkglass::measure::vary::{Asked, Outcome, lack};

/// All axes with their values, and what the device lacks for each.
pub(super) fn list(axes: &[Asked], device: Option<&Device>) -> String {
    let mut text = device.map_or_else(String::new, |device| format!("{}, {}\n", device.name(), device.driver()));
    for asked in axes {
        text += &format!("\n{}: {}\n", asked.name, asked.axis.about);
        let row = |value: &milkglass::internals::gpu::Value| {
            let mut choices = Choices::default();
            (value.set)(&mut choices);
            let lacks = device.and_then(|device| lack(device.adapter(), &choices)).unwrap_or_default();
            let mark = if value.name == asked.default { " (default)" } else { "" };
            vec![format!("  {}", value.name), format!("{}{mark}", value.about), lacks]
        };
        let rows: Vec<Vec<String>> = asked.axis.values.iter().map(row).collect();
        text += &table(["  value", "what it means", "lacks"], rows);
    }
    text
}

/// A table with a row for each variant: the whole frame, and the stages that show a difference.
pub(super) fn summary(outcomes: &[Outcome]) -> String {
    let mut rows = Vec::new();
    for outcome in outcomes {
        for (variant, ratios) in outcome.timed() {
            let whole = ratios.iter().rfind(|row| row.what == "frame").or_else(|| ratios.last());
            let cells = whole.map_or_else(|| ["-".into(), "-".into()], cells);
            let stages: Vec<String> = ratios
                .iter()
                .filter(|row| row.what != "frame")
                .filter_map(|row| Some(format!("{} {:.3} {}", row.what, row.ratio.value, row.finding()?)))
                .collect();
            let finding = whole.map_or("", Ratio::shows);
            let [ratio, interval] = cells;
            rows.push(vec![variant.name.clone(), ratio, interval, finding.into(), stages.join(", ")]);
        }
    }
    if rows.is_empty() {
        return "\nnothing was timed\n".into();
    }
    let header = ["variant", "frame", "interval", "shows", "parts of it that differ"];
    format!(
        "\nEach variant against the default: the ratio of a frame's time, and its interval. All intervals of an axis hold \
         together\nwith 95 % (Hodges-Lehmann, signed ranks, over each start's median ratio); * excludes 1.\n\n{}",
        table(header, rows)
    )
}

fn cells(row: &Ratio) -> [String; 2] {
    let interval = match row.ratio.high.is_finite() {
        true => format!("{:.3}..{:.3}", row.ratio.low, row.ratio.high),
        false => "too few".into(),
    };
    [format!("{:.3}", row.ratio.value), interval]
}

/// A table of the stages of an axis: the default's times, and each variant's ratio to them.
pub(super) fn stages(outcome: &Outcome) -> String {
    let Outcome { samples, ratios, asked, .. } = outcome;
    let Some(first) = ratios.first() else { return String::new() };
    let values: Vec<&str> = outcome.timed().map(|(variant, _)| variant.name.as_str()).collect();
    let default = format!("{}={} ms", asked.name, asked.default);
    let header: Vec<&str> =
        ["stage", &default, "+-"].into_iter().chain(values.iter().flat_map(|name| [*name, ""])).collect();
    let row = |(k, row): (usize, &Ratio)| {
        let own = [row.what.clone(), format!("{:.3}", row.ms[0].value), half(&row.ms[0])];
        let others = ratios.iter().flat_map(|rows| match rows.get(k).filter(|other| other.what == row.what) {
            Some(other) => {
                let mark = if other.finding().is_some() { " *" } else { "" };
                let [ratio, interval] = cells(other);
                [ratio, format!("{interval}{mark}")]
            }
            None => ["-".into(), String::new()],
        });
        own.into_iter().chain(others).collect()
    };
    let rows: Vec<Vec<String>> = first.iter().enumerate().map(row).collect();
    let mut text = format!("\n{}\n{}", rounds(samples), table(header, rows));
    samples.doubts().iter().for_each(|doubt| text += &format!("{doubt}\n"));
    text
}
