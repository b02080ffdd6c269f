//! Measurements as a drawing: panels of lines, dots and intervals on linear or logarithmic axes, in SVG.

mod axis;
mod series;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub use axis::Axis;
pub use series::{Mark, Point, Series};

use crate::error::{Error, Result};

/// A palette for colour-blind readers (Okabe and Ito).
pub const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// The colours of the channels.
pub const CHANNELS: [RGBColor; 3] = [RGBColor(200, 45, 40), RGBColor(30, 140, 55), RGBColor(40, 80, 200)];
/// Colours of text, of the lines at labels, and of those between them.
const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(205, 205, 205);
const MINOR: RGBColor = RGBColor(238, 238, 238);

/// Size of a panel without its legend, pixels: about as wide as a phone's screen, so that its text stays legible there.
pub const SIZE: [i32; 2] = [480, 360];
/// Height of a line of the title and of a legend, pixels.
const LINE: i32 = 22;
/// Width of the labels on the left, pixels: of numbers, and of names.
const LEFT: [i32; 2] = [62, 150];
/// More dots than this in a panel are drawn small.
const MANY: usize = 600;

/// From blue for 0 to red for 1.
#[must_use]
pub fn hue(share: f64) -> RGBColor {
    let (red, green, blue) = HSLColor(0.66 * (1.0 - share.clamp(0.0, 1.0)), 0.85, 0.4).rgb();
    RGBColor(red, green, blue)
}

/// A drawing area of pixels.
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

fn words(root: &Area<'_>, text: &str, at: (i32, i32), size: u32) -> Drawn {
    let style = ("sans-serif", size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    Ok(root.draw_text(text, &style, at)?)
}

/// Axes, and what is shown between them.
#[derive(Clone)]
pub struct Panel {
    /// The text above the panel.
    pub title: String,
    /// Its axes: across and upwards.
    pub axes: [Axis; 2],
    /// The series that it shows.
    pub series: Vec<Series>,
    /// Its size without its legend, pixels.
    pub size: [i32; 2],
}

impl Panel {
    /// A panel of the usual size.
    pub fn new(title: impl Into<String>, axes: [Axis; 2], series: impl IntoIterator<Item = Series>) -> Self {
        Self { title: title.into(), axes, series: series.into_iter().collect(), size: SIZE }
    }

    /// The drawing of this panel alone.
    pub fn svg(self) -> Result<String> {
        Plot { panels: vec![self], ..Plot::default() }.svg()
    }

    /// The points of a series that have a place on both axes.
    fn placed<'a>(&'a self, series: &'a Series) -> impl Iterator<Item = &'a Point> {
        series.points.iter().filter(|point| (0..2).all(|k| self.axes[k].shows(point.place[k])))
    }

    /// Draws the panel with its upper left corner here and with these ends of its axes.
    fn draw(&self, root: &Area<'_>, corner: (i32, i32), ends: [[f64; 2]; 2]) -> Drawn {
        let [x, y] = ends.map(|[low, high]| low..high);
        let [a, b] = [0, 1].map(|k| self.axes[k].ticks(ends[k]));
        match [0, 1].map(|k| self.axes[k].log) {
            [false, false] => self.draw_on(root, corner, keyed(x, a), keyed(y, b)),
            [true, false] => self.draw_on(root, corner, keyed(x.log_scale(), a), keyed(y, b)),
            [false, true] => self.draw_on(root, corner, keyed(x, a), keyed(y.log_scale(), b)),
            [true, true] => self.draw_on(root, corner, keyed(x.log_scale(), a), keyed(y.log_scale(), b)),
        }
    }

    fn draw_on<X, Y>(&self, root: &Area<'_>, corner: (i32, i32), x: Keyed<X>, y: Keyed<Y>) -> Drawn
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        let ends = [x.range(), y.range()].map(|ends| [ends.start.min(ends.end), ends.start.max(ends.end)]);
        let area = root.clone().shrink(corner, (self.size[0], self.size[1]));
        let [across, upwards] = &self.axes;
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 16).into_font().color(&INK))
            .margin(8)
            .margin_right(18)
            .x_label_area_size(44)
            .y_label_area_size(LEFT[usize::from(!upwards.names.is_empty())])
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .x_desc(&across.label)
            .y_desc(&upwards.label)
            .x_label_formatter(&|number| across.name(*number))
            .y_label_formatter(&|number| upwards.name(*number))
            .label_style(("sans-serif", 13))
            .axis_desc_style(("sans-serif", 14))
            .bold_line_style(GRID)
            .light_line_style(MINOR)
            .draw()?;
        let at = |[x, y]: [f64; 2]| {
            let [x, y] = [(x, ends[0]), (y, ends[1])].map(|(place, [low, high])| place.clamp(low, high));
            chart.backend_coord(&(x, y))
        };
        let dots = self.series.iter().filter(|series| series.mark == Mark::Dots);
        let small = dots.map(|series| series.points.len()).sum::<usize>() > MANY;
        // Bands lie below all others.
        let mut order: Vec<usize> = (0..self.series.len()).collect();
        order.sort_by_key(|k| self.series[*k].mark != Mark::Band);
        for k in order {
            let series = &self.series[k];
            let points = self.placed(series).cloned().collect();
            Series { points, ..series.clone() }.draw(root, k, small, &at)?;
        }
        Ok(())
    }
}

/// An axis with labels and lines at the first list of numbers, and with lines only at the second.
struct Keyed<R> {
    inner: R,
    ticks: [Vec<f64>; 2],
}

fn keyed<R: AsRangedCoord<Value = f64>>(range: R, ticks: [Vec<f64>; 2]) -> Keyed<R::CoordDescType> {
    Keyed { inner: range.into(), ticks }
}

impl<R: Ranged<ValueType = f64>> Ranged for Keyed<R> {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, number: &f64, pixels: (i32, i32)) -> i32 {
        self.inner.map(number, pixels)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.ticks[usize::from(hint.weight().allow_light_points())].clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.inner.range()
    }
}

/// Panels beside and below each other.
#[derive(Clone, Default)]
pub struct Plot {
    /// Lines of text above all of them.
    pub title: Vec<String>,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// The number of panels in a row; 0 counts as 1.
    pub columns: usize,
    /// Whether all have the same axes, and one legend below all of them.
    pub shared: bool,
}

impl Plot {
    /// The drawing.
    pub fn svg(&self) -> Result<String> {
        let mut picture = String::new();
        self.draw(&mut picture).map_err(|error| Error::Check(format!("the plot could not be drawn: {error}")))?;
        Ok(picture)
    }

    fn draw(&self, picture: &mut String) -> Drawn {
        let rows: Vec<&[Panel]> = self.panels.chunks(self.columns.max(1)).collect();
        let width = |row: &&[Panel]| row.iter().map(|panel| panel.size[0]).sum::<i32>();
        let wide = rows.iter().map(width).max().unwrap_or(SIZE[0]);
        let legend = |panel: &Panel| if self.shared { 0 } else { entries(&panel.series, panel.size[0]).1 };
        let height = |row: &&[Panel]| row.iter().map(|panel| panel.size[1] + legend(panel)).max().unwrap_or(0);
        let common = self.panels.first().filter(|_| self.shared).map_or(&[][..], |panel| &panel.series);
        let mut top = LINE * self.title.len() as i32;
        let high = top + rows.iter().map(height).sum::<i32>() + entries(common, wide).1;

        let root = SVGBackend::with_string(picture, (wide as u32, high as u32)).into_drawing_area();
        root.fill(&WHITE)?;
        for (line, text) in (0..).zip(&self.title) {
            words(&root, text, (24, LINE * line + LINE / 2 + 4), if line == 0 { 17 } else { 13 })?;
        }
        for row in &rows {
            let mut left = 0;
            for panel in *row {
                panel.draw(&root, (left, top), self.ends(panel))?;
                if !self.shared {
                    key(&root, &panel.series, panel.size[0], (left, top + panel.size[1]))?;
                }
                left += panel.size[0];
            }
            top += height(row);
        }
        key(&root, common, wide, (0, top))?;
        Ok(root.present()?)
    }

    /// The ends of a panel's axes.
    fn ends(&self, panel: &Panel) -> [[f64; 2]; 2] {
        let alike = if self.shared { &self.panels[..] } else { std::slice::from_ref(panel) };
        let points = alike.iter().flat_map(|panel| panel.series.iter().flat_map(|series| panel.placed(series)));
        let places: Vec<[f64; 2]> = points.map(|point| point.place).collect();
        [0, 1].map(|k| panel.axes[k].range(places.iter().map(|place| place[k])))
    }
}

/// An entry of a legend: the number of its series, and its place.
type Entry = (usize, (i32, i32));

/// The legend's entries, one for each name, and its height; a legend of a single entry is left out.
fn entries(series: &[Series], wide: i32) -> (Vec<Entry>, i32) {
    let (mut list, mut x, mut y): (Vec<Entry>, _, _) = (Vec::new(), LEFT[0], LINE / 2);
    for (k, Series { name, .. }) in series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()) {
        if list.iter().any(|(known, _)| series[*known].name == *name) {
            continue;
        }
        let width = 44 + 7 * name.chars().count() as i32;
        if x > LEFT[0] && x + width > wide {
            (x, y) = (LEFT[0], y + LINE);
        }
        list.push((k, (x, y)));
        x += width;
    }
    if list.len() < 2 { (Vec::new(), 0) } else { (list, y + LINE) }
}

/// Draws the legend with its upper left corner here.
fn key(root: &Area<'_>, series: &[Series], wide: i32, (left, top): (i32, i32)) -> Drawn {
    for (k, (x, y)) in entries(series, wide).0 {
        let (own, x, y) = (&series[k], f64::from(left + x), f64::from(top + y));
        let pixel = |[x, y]: [f64; 2]| (x as i32, y as i32);
        let sample = |mark, places: &[f64]| {
            let places = places.iter().map(|place| (x + place, y));
            Series::new("", mark, places).colored(own.color(k)).draw(root, k, false, &pixel)
        };
        match own.mark {
            Mark::Dots => {}
            Mark::Curve | Mark::Bars => sample(Mark::Line, &[0.0, 24.0])?,
            line => sample(line, &[0.0, 24.0])?,
        }
        if matches!(own.mark, Mark::Dots | Mark::Curve) {
            sample(own.mark, &[12.0])?;
        }
        words(root, &own.name, (x as i32 + 30, y as i32), 13)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
