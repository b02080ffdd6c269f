//! A profile as a roofline: each row by its intensity, operations a byte, and its rate, under what the device can do.

use super::{Profile, Row};
use crate::error::Result;
use crate::measure::plot::{Axis, COLORS, Mark, Panel, Plot, Point, Series};

/// Size of the drawing, pixels.
const SIZE: [i32; 2] = [760, 480];
/// A row that takes less than this share of all has no name beside its dot.
const NAMED: f64 = 0.02;

/// The place of a row: operations a byte of its least traffic, and G operations a second; none without both.
fn place(row: &Row) -> Option<[f64; 2]> {
    let (work, seconds) = (row.work?, row.seconds()?);
    let (flops, bytes) = (work.flops as f64, (work.read + work.written) as f64);
    (flops > 0.0 && bytes > 0.0).then(|| [flops / bytes, 1e-9 * flops / seconds])
}

/// Draws a profile; none where the device's rates or the work of its rows are not known.
pub fn roofline(found: &Profile) -> Result<Option<String>> {
    let Some(rates) = &found.rates else { return Ok(None) };
    let time = |row: &Row| row.seconds().unwrap_or_default();
    let whole: f64 = found.rows.iter().map(time).sum();
    let dot = |row: &Row| {
        let large = time(row) >= NAMED * whole;
        // `link/count` of a kernel in full.
        let short = row.stage.rmatch_indices('/').nth(1).map_or(0, |(at, _)| at + 1);
        let label = if large { row.stage[short..].to_string() } else { String::new() };
        Some((large, Point { place: place(row)?, label, ..Point::default() }))
    };
    let dots: Vec<(bool, Point)> = found.rows.iter().filter_map(dot).collect();
    if dots.is_empty() {
        return Ok(None);
    }
    // A fused multiply-add is two operations. The roof bends where both rates are used up.
    let (copy, most) = (1e-9 * rates.copy, 2e-9 * rates.fma);
    let bend = most / copy;
    let ends = dots.iter().map(|(_, dot)| dot.place[0]).chain([bend]);
    let (low, high) = ends.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let (low, high) = (0.5 * low, 2.0 * high);
    let roof = Series::line(
        format!("the device: {copy:.1} GB/s, {most:.1} G flop/s"),
        [(low, low * copy), (bend, most), (high, most)],
    );
    let share = |large: bool, name: &str, color: usize| Series {
        points: dots.iter().filter(|(own, _)| *own == large).map(|(_, dot)| dot.clone()).collect(),
        ..Series::new(name, Mark::Dots, []).colored(COLORS[color])
    };
    let series = [roof, share(true, "rows that take 2 % of the time or more", 1), share(false, "the others", 5)];
    let axes = [Axis::log("flop a byte, each bound byte once at most").within([low, high]), Axis::log("G flop/s")];
    let title = [
        format!("{}: {} rows that count floats", found.scene, dots.len()),
        format!("{}, {}; medians of {} frames", found.device, found.driver, found.frames),
    ];
    let panels = vec![Panel { size: SIZE, ..Panel::new("", axes, series) }];
    Ok(Some(Plot { title: title.to_vec(), panels, ..Plot::default() }.svg()?))
}

#[cfg(test)]
mod tests {
    use super::super::{Quantiles, Rates, Work};
    use super::*;

    fn row(stage: &str, flops: u64, read: u64, ms: f64) -> Row {
        let times = Quantiles::of(vec![ms; 3]);
        let work = Some(Work { flops, read, ..Work::default() });
        Row { stage: stage.into(), steps: 1, dispatches: 1, device: Some(times), interval: None, wall: times, work }
    }

    #[test]
    fn a_row_lies_where_its_work_and_time_put_it() {
        // 8 flop a byte, at 4 G flop/s.
        assert_eq!(place(&row("a", 4_000_000, 500_000, 1.0)), Some([8.0, 4.0]));
        for without in [row("a", 0, 5, 1.0), row("a", 5, 0, 1.0), row("a", 5, 5, 0.0)] {
            assert_eq!(place(&without), None);
        }
    }

    #[test]
    fn rows_lie_under_the_roof() {
        let rates = Rates { copy: 1e10, fma: 2e10, exp: 1e9 };
        let rows = vec![
            row("a/b/gather/edge", 4_000_000, 500_000, 1.0),
            row("push", 400, 4_000, 0.001),
            row("copy", 0, 8, 1.0),
        ];
        let times = Quantiles::of(vec![1.0]);
        let found = Profile {
            scene: "ball".into(),
            device: "d".into(),
            driver: "v".into(),
            frames: 3,
            rates: Some(rates),
            rows,
            wall: times,
            on_device: None,
            peak: 0,
            notes: Vec::new(),
            samples: Default::default(),
            trace: Vec::new(),
        };
        let drawing = roofline(&found).unwrap().unwrap();
        for words in ["10.0 GB/s, 40.0 G flop/s", "\ngather/edge\n", "ball: 2 rows", "G flop/s"] {
            assert!(drawing.contains(words), "{words}: {drawing}");
        }
        assert!(!drawing.contains("push"), "it takes too little time for a name");
        assert!(roofline(&Profile { rates: None, ..found }).unwrap().is_none());
    }
}
