//! Ratios of variants to the default as SVG: a strip for each stage, in it a bar for each variant's interval.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Outcome;
use crate::error::{Error, Result};
use crate::measure::pareto::COLORS;
use crate::measure::rounds::Ratio;

/// Width of the drawing, pixels.
const WIDE: u32 = 640;
/// Height of a variant's bar, pixels.
const BAR: i32 = 9;
/// Height of the space between strips, pixels.
const GAP: i32 = 7;
/// Height of a line of text, pixels.
const HEAD: i32 = 26;
/// Height of what is below the strips, pixels.
const FOOT: i32 = 34;
/// Width of the stages' names, pixels.
const NAMES: i32 = 150;
/// Width of the margin on the right, pixels.
const MARGIN: i32 = 16;
/// A stage that takes less than this share of the default's stages has no strip.
const LEAST: f64 = 0.02;

type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

/// Draws the axes that were timed, one below the other.
pub fn strips(scene: &str, outcomes: &[Outcome]) -> Result<String> {
    let drawn: Vec<&Outcome> = outcomes.iter().filter(|outcome| !outcome.ratios.is_empty()).collect();
    let high: i32 = HEAD + drawn.iter().map(|outcome| height(outcome)).sum::<i32>();
    let mut picture = String::new();
    let mut done = || -> Drawn {
        let root = SVGBackend::with_string(&mut picture, (WIDE, high as u32)).into_drawing_area();
        root.fill(&WHITE)?;
        let title = format!("{scene}: time of a variant over that of the default, with its interval");
        root.draw_text(&title, &text(14, HPos::Left), (8, HEAD / 2))?;
        let mut top = HEAD;
        for outcome in &drawn {
            axis(&root, outcome, top)?;
            top += height(outcome);
        }
        root.present()?;
        Ok(())
    };
    done().map_err(|error| Error::Check(format!("the strips could not be drawn: {error}")))?;
    Ok(picture)
}

/// The rows that have a strip: stages that matter, their sum, and the frame.
fn rows(outcome: &Outcome) -> Vec<&str> {
    let Some(first) = outcome.ratios.first() else { return Vec::new() };
    let time = |row: &Ratio| row.ms[0].value;
    let whole = first.iter().find(|row| row.what == "stages").or_else(|| first.last()).map_or(0.0, time);
    first.iter().filter(|row| time(row) >= LEAST * whole).map(|row| row.what.as_str()).collect()
}

fn strip(outcome: &Outcome) -> i32 {
    outcome.ratios.len() as i32 * BAR + GAP
}

fn height(outcome: &Outcome) -> i32 {
    2 * HEAD + rows(outcome).len() as i32 * strip(outcome) + FOOT
}

fn text(size: u32, side: HPos) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK).pos(Pos::new(side, VPos::Center))
}

/// The least and the largest ratio that an axis shows; it holds 1.
fn range(outcome: &Outcome) -> [f64; 2] {
    let names = rows(outcome);
    let shown = outcome.ratios.iter().flatten().filter(|row| names.contains(&row.what.as_str()));
    let ends = shown.flat_map(|row| [row.ratio.value, row.ratio.low, row.ratio.high]).filter(|end| end.is_finite());
    let [low, high] = ends.fold([0.95, 1.05], |[low, high]: [f64; 2], end| [low.min(end), high.max(end)]);
    let margin = 0.03 * (high - low);
    [(low - margin).max(0.0), (high + margin).min(4.0)]
}

/// Steps of 1, 2 or 5 between ticks, about six of them.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|step| *step >= rough).unwrap_or(power);
    let first = (low / step).ceil() as i64;
    (first..).map(|k| k as f64 * step).take_while(|tick| *tick <= high).collect()
}

fn axis<B: DrawingBackend>(root: &DrawingArea<B, plotters::coord::Shift>, outcome: &Outcome, top: i32) -> Drawn
where
    B::ErrorType: 'static,
{
    let ends = range(outcome);
    let [left, right] = [NAMES, WIDE as i32 - MARGIN];
    let at = |ratio: f64| {
        left + ((ratio.clamp(ends[0], ends[1]) - ends[0]) / (ends[1] - ends[0]) * f64::from(right - left)) as i32
    };
    root.draw_text(
        &format!("{}: {}", outcome.asked.name, outcome.asked.axis.about),
        &text(13, HPos::Left),
        (8, top + HEAD / 2),
    )?;
    let mut x = 8;
    for (k, (variant, _)) in outcome.timed().enumerate() {
        let color = COLORS[k % COLORS.len()];
        root.draw(&Rectangle::new([(x, top + HEAD + 4), (x + 12, top + HEAD + 12)], color.filled()))?;
        let name = variant.name.rsplit('=').next().unwrap_or_default();
        root.draw_text(name, &text(12, HPos::Left), (x + 16, top + HEAD + 8))?;
        x += 32 + 7 * name.chars().count() as i32;
    }
    let names = rows(outcome);
    let (first, strip) = (top + 2 * HEAD, strip(outcome));
    let last = first + names.len() as i32 * strip;
    let grey = RGBColor(205, 205, 205);
    for tick in ticks(ends) {
        root.draw(&PathElement::new([(at(tick), first), (at(tick), last + 3)], grey))?;
        root.draw_text(&format!("{}", (tick * 1e4).round() / 1e4), &text(11, HPos::Center), (at(tick), last + 12))?;
    }
    root.draw(&PathElement::new([(at(1.0), first), (at(1.0), last)], BLACK))?;
    for (k, name) in names.iter().enumerate() {
        let y = first + k as i32 * strip;
        if k % 2 == 0 {
            root.draw(&Rectangle::new([(8, y), (right, y + strip)], RGBColor(0, 0, 0).mix(0.05).filled()))?;
        }
        root.draw_text(name, &text(12, HPos::Right), (left - 8, y + strip / 2))?;
        for (k, (_, rows)) in outcome.timed().enumerate() {
            let Some(row) = rows.iter().find(|row| row.what == *name) else { continue };
            let (color, middle) = (COLORS[k % COLORS.len()], y + GAP / 2 + k as i32 * BAR + BAR / 2);
            let [low, high] = [row.ratio.low, row.ratio.high].map(at);
            root.draw(&PathElement::new([(low, middle), (high, middle)], color.stroke_width(2)))?;
            // An interval that goes on beyond the drawing has no end.
            for (end, place) in [(row.ratio.low, low), (row.ratio.high, high)] {
                if (ends[0]..=ends[1]).contains(&end) {
                    root.draw(&PathElement::new([(place, middle - 3), (place, middle + 3)], color.stroke_width(1)))?;
                }
            }
            root.draw(&Circle::new((at(row.ratio.value), middle), 3, color.filled()))?;
        }
    }
    Ok(())
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
        assert_eq!(ticks([0.9, 1.3]), [9, 10, 11, 12, 13].map(|k| f64::from(k) * 0.1));
    }
}
