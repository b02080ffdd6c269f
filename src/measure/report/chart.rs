//! A plot as SVG: lines and dots on linear or logarithmic axes, each with its name and unit.

use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::error::{Error, Result};
use crate::measure::pareto::COLORS;

/// An axis.
#[derive(Clone, Copy)]
pub struct Axis<'a> {
    /// The label, with the unit.
    pub label: &'a str,
    /// Whether it is logarithmic; then it shows positive numbers only.
    pub log: bool,
}

/// The style of a line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Connects the points.
    Line,
    /// One dot per point.
    Dots,
}

/// One data series: a line, or dots.
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// The style.
    pub mark: Mark,
    /// The points; those that are not finite, or do not fit a logarithmic axis, are left out.
    pub points: Vec<(f64, f64)>,
    /// The colour, if not the next one of the palette.
    pub color: Option<RGBColor>,
}

/// The colours of the channels.
pub const CHANNELS: [RGBColor; 3] = [RGBColor(200, 45, 40), RGBColor(30, 140, 55), RGBColor(40, 80, 200)];

impl Line {
    /// A line.
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.into(), mark: Mark::Line, points: points.into_iter().collect(), color: None }
    }

    /// Dots.
    pub fn dots(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { mark: Mark::Dots, ..Self::new(name, points) }
    }
}

/// Size of a plot without its legend, pixels: about as wide as a phone's screen, so that its text stays legible
/// there.
const SIZE: (u32, u32) = (480, 360);
/// Height of a line of the two-column legend, pixels.
const ROW: u32 = 20;
/// Draws the plot.
pub fn chart(title: &str, x: Axis<'_>, y: Axis<'_>, lines: &[Line]) -> Result<String> {
    let placed = |&(a, b): &(f64, f64)| a.is_finite() && b.is_finite() && !(x.log && a <= 0.0) && !(y.log && b <= 0.0);
    let kept: Vec<(&Line, Vec<(f64, f64)>)> =
        lines.iter().map(|line| (line, line.points.iter().copied().filter(placed).collect())).collect();
    let all = || kept.iter().flat_map(|(_, points)| points);
    let (wide, high) = (range(all().map(|p| p.0), x.log), range(all().map(|p| p.1), y.log));
    let mut picture = String::new();
    let drawn = match (x.log, y.log) {
        (false, false) => draw(&mut picture, title, [x, y], wide, high, &kept),
        (true, false) => draw(&mut picture, title, [x, y], wide.log_scale(), high, &kept),
        (false, true) => draw(&mut picture, title, [x, y], wide, high.log_scale(), &kept),
        (true, true) => draw(&mut picture, title, [x, y], wide.log_scale(), high.log_scale(), &kept),
    };
    drawn.map_err(|error| Error::Check(format!("the plot could not be drawn: {error}")))?;
    Ok(picture)
}

/// The range of the numbers with a margin; never empty.
fn range(numbers: impl Iterator<Item = f64>, log: bool) -> std::ops::Range<f64> {
    let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    match (low > high, log) {
        (true, true) => 0.1..1.0,
        (true, false) => 0.0..1.0,
        (false, true) => low / 1.3..high * 1.3,
        (false, false) => {
            let margin = 0.04 * (high - low).max(1e-9 * high.abs()).max(1e-300);
            // Start at 0 if that is near.
            let start = if low >= 0.0 && low < 0.3 * high { 0.0 } else { low - margin };
            start..high + margin
        }
    }
}

/// A number on an axis, with an exponent if it would be long.
fn short(number: &f64) -> String {
    let number: f64 = format!("{number:.3e}").parse().unwrap_or(*number);
    if number == 0.0 || (0.01..1e4).contains(&number.abs()) { number.to_string() } else { format!("{number:e}") }
}

type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw<X, Y>(
    picture: &mut String,
    title: &str,
    axes: [Axis<'_>; 2],
    x: X,
    y: Y,
    lines: &[(&Line, Vec<(f64, f64)>)],
) -> Drawn
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let rows = if lines.len() > 1 { lines.len().div_ceil(2) as u32 } else { 0 };
    let root = SVGBackend::with_string(picture, (SIZE.0, SIZE.1 + ROW * rows)).into_drawing_area();
    root.fill(&WHITE)?;
    let (plane, legend) = root.split_vertically(SIZE.1);
    let mut chart = ChartBuilder::on(&plane)
        .caption(title, ("sans-serif", 16))
        .margin(8)
        .margin_right(18)
        .x_label_area_size(44)
        .y_label_area_size(62)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .x_desc(axes[0].label)
        .y_desc(axes[1].label)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .x_labels(6)
        .y_labels(7)
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .light_line_style(WHITE)
        .draw()?;
    let many = lines.iter().map(|(_, points)| points.len()).sum::<usize>() > 600;
    for (k, (line, points)) in lines.iter().enumerate() {
        let color = line.color.unwrap_or(COLORS[k % COLORS.len()]);
        let (x, y) = (62 + 210 * (k as i32 % 2), (ROW as i32) * (k as i32 / 2) + ROW as i32 / 2);
        match line.mark {
            Mark::Line => {
                chart.draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(2)))?;
                legend.draw(&PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)))?;
            }
            Mark::Dots => {
                let size = if many { 1 } else { 3 };
                chart.draw_series(points.iter().map(|&point| Circle::new(point, size, color.filled())))?;
                legend.draw(&Circle::new((x + 8, y), 3, color.filled()))?;
            }
        }
        if rows > 0 {
            let style = ("sans-serif", 13).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
            legend.draw_text(&line.name, &style, (x + 22, y))?;
        }
    }
    root.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_names_its_axes_and_leaves_out_what_has_no_place() {
        let axis = |label, log| Axis { label, log };
        let lines = [
            Line::new("up & down", [(1.0, 1.0), (2.0, 0.0), (3.0, 5.0)]),
            Line::dots("odd", [(2.0, f64::NAN), (2.0, 2.0)]),
        ];
        for (a, b) in [(false, false), (true, false), (false, true), (true, true)] {
            let svg = chart("a plot", axis("x, mm", a), axis("y, W", b), &lines).unwrap();
            for words in ["<svg", "a plot", "x, mm", "y, W", "up &amp; down", "odd"] {
                assert!(svg.contains(words), "{words}");
            }
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            // A plot without data is not an error.
            assert!(chart("empty", axis("x", a), axis("y", b), &[]).unwrap().contains("empty"));
        }
    }
}
