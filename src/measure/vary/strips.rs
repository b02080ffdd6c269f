//! Ratios of variants to the default as SVG: a panel for each axis, in it a strip for each stage with the variants'
//! intervals.

use super::Outcome;
use crate::error::Result;
use crate::measure::plot::{Axis, Mark, Panel, Plot, Point, Series};
use crate::measure::rounds::Ratio;

/// Width of a panel, and the height of what is above and below its strips, pixels.
const SIZE: [i32; 2] = [640, 100];
/// Height of a variant's bar, and of the space between strips, pixels.
const BAR: [i32; 2] = [9, 7];
/// A stage that takes less than this share of the default's stages has no strip.
const LEAST: f64 = 0.02;

/// Draws the axes that were timed, one below the other.
pub fn strips(scene: &str, outcomes: &[Outcome]) -> Result<String> {
    let title = format!("{scene}: time of a variant over that of the default, with its interval");
    let panels = outcomes.iter().filter(|outcome| !outcome.ratios.is_empty()).map(panel).collect();
    Plot { title: vec![title], panels, ..Plot::default() }.svg()
}

/// The rows that have a strip: stages that matter, their sum, and the frame.
fn rows(outcome: &Outcome) -> Vec<String> {
    let Some(first) = outcome.ratios.first() else { return Vec::new() };
    let time = |row: &Ratio| row.ms[0].value;
    let whole = first.iter().find(|row| row.what == "stages").or_else(|| first.last()).map_or(0.0, time);
    first.iter().filter(|row| time(row) >= LEAST * whole).map(|row| row.what.clone()).collect()
}

/// The least and the largest ratio that an axis shows; it holds 1.
fn range(points: &[&Point]) -> [f64; 2] {
    let ends = points.iter().flat_map(|point| point.ends.into_iter().flatten().chain([point.place]));
    let ends = ends.map(|[ratio, _]| ratio).filter(|ratio| ratio.is_finite());
    let [low, high] = ends.fold([0.95, 1.05], |[low, high]: [f64; 2], end| [low.min(end), high.max(end)]);
    let margin = 0.03 * (high - low);
    [(low - margin).max(0.0), (high + margin).min(4.0)]
}

fn panel(outcome: &Outcome) -> Panel {
    let (names, variants) = (rows(outcome), outcome.ratios.len());
    let mut series = Vec::new();
    for (k, (variant, rows)) in outcome.timed().enumerate() {
        let beside = 0.8 * ((k as f64 + 0.5) / variants as f64 - 0.5);
        let point = |(place, name): (usize, &String)| {
            let place = place as f64 + beside;
            let ratio = &rows.iter().find(|row| row.what == *name)?.ratio;
            let ends = Some([[ratio.low, place], [ratio.high, place]]);
            Some(Point { place: [ratio.value, place], ends, ..Point::default() })
        };
        let name = variant.name.rsplit('=').next().unwrap_or_default();
        let points = names.iter().enumerate().filter_map(point).collect();
        series.push(Series { points, ..Series::new(name, Mark::Dots, []) });
    }
    let ends = range(&series.iter().flat_map(|series| &series.points).collect::<Vec<_>>());
    let default = [(1.0, -0.5), (1.0, names.len() as f64 - 0.5)];
    series.push(Series::line("default", default).colored(plotters::style::BLACK));
    let height = SIZE[1] + names.len() as i32 * (variants as i32 * BAR[0] + BAR[1]);
    let axes = [Axis::linear("").within(ends), Axis::names(names)];
    let title = format!("{}: {}", outcome.asked.name, outcome.asked.axis.about);
    Panel { size: [SIZE[0], height], ..Panel::new(title, axes, series) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::rounds::Samples;
    use crate::measure::statistics::Interval;
    use crate::measure::vary::{Proof, Tried, asked};

    #[test]
    fn each_stage_that_matters_has_a_strip() {
        let ratio = |what: &str, ms: f64, value: f64, high: f64| Ratio {
            what: what.into(),
            ms: [ms, ms * value].map(|value| Interval { value, low: value, high: value }),
            ratio: Interval { value, low: value - 0.1, high },
            missing_rounds: 0,
        };
        let rows = |high: f64| {
            vec![ratio("gather", 5.0, 1.2, high), ratio("tiny", 0.01, 1.0, 1.1), ratio("stages", 5.01, 1.2, high)]
        };
        let proof = || Tried::Proved(Proof::Same { buffers: 1, bytes: 4 });
        let outcome = Outcome {
            asked: asked("constants").unwrap(),
            tried: vec![Tried::Lacks("nothing".into()), proof()],
            samples: Samples::default(),
            ratios: vec![rows(f64::INFINITY)],
        };
        let svg = strips("a <scene>", &[outcome]).unwrap();
        for word in ["a &lt;scene&gt;", "specialization", "gather", "stages", "constants: where"] {
            assert!(svg.contains(word), "{word}: {svg}");
        }
        assert!(!svg.contains("tiny") && !svg.contains("uniform") && !svg.contains("NaN") && !svg.contains("inf"));
        assert!(strips("empty", &[]).unwrap().contains("empty"));
    }
}
