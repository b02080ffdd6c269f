//! Points that belong together, and how they are drawn.

use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::{Area, COLORS, Drawn, words};

/// The colour of a band.
const BAND: RGBColor = RGBColor(222, 222, 222);

/// How the points of a series are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line connects them.
    Line,
    /// A dashed line connects them.
    Dashes,
    /// A broad and pale line connects them.
    Band,
    /// Dots.
    Dots,
    /// A line, and a marker at each point, whose shape is the series' own.
    Curve,
    /// Intervals.
    Bars,
}

/// A point of a series.
#[derive(Clone, Default)]
pub struct Point {
    /// Its place along both axes.
    pub place: [f64; 2],
    /// The ends of an interval through it.
    pub ends: Option<[[f64; 2]; 2]>,
    /// Words beside its marker.
    pub label: String,
    /// Whether the marker is hollow.
    pub hollow: bool,
}

/// Points that belong together.
#[derive(Clone)]
pub struct Series {
    /// Its name in the legend, which leaves out a series without a name.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// Its points; those that no axis can show are left out.
    pub points: Vec<Point>,
    /// Its colour, if not the next one of the palette.
    pub color: Option<RGBColor>,
}

impl Series {
    /// Points of a series.
    pub fn new(name: impl Into<String>, mark: Mark, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let point = |(x, y)| Point { place: [x, y], ..Point::default() };
        Self { name: name.into(), mark, points: points.into_iter().map(point).collect(), color: None }
    }

    /// A line.
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(name, Mark::Line, points)
    }

    /// Dots.
    pub fn dots(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(name, Mark::Dots, points)
    }

    /// The same in this colour.
    #[must_use]
    pub fn colored(self, color: RGBColor) -> Self {
        Self { color: Some(color), ..self }
    }

    /// Its colour as the `k`-th of a panel.
    pub(super) fn color(&self, k: usize) -> RGBColor {
        self.color.unwrap_or(if self.mark == Mark::Band { BAND } else { COLORS[k % COLORS.len()] })
    }

    /// Draws its points as the `k`-th series of a panel, at the pixels that `at` gives.
    pub(super) fn draw(&self, root: &Area<'_>, k: usize, small: bool, at: &dyn Fn([f64; 2]) -> (i32, i32)) -> Drawn {
        let color = self.color(k);
        let line = self.points.iter().map(|point| at(point.place));
        match self.mark {
            Mark::Line | Mark::Curve => {
                root.draw(&PathElement::new(line.collect::<Vec<_>>(), color.stroke_width(2)))?
            }
            Mark::Band => root.draw(&PathElement::new(line.collect::<Vec<_>>(), color.stroke_width(10)))?,
            Mark::Dashes => root.draw(&DashedPathElement::new(line, 5, 3, color.stroke_width(1)))?,
            Mark::Dots | Mark::Bars => {}
        }
        for point in &self.points {
            let place = at(point.place);
            if let Some(ends) = point.ends {
                root.draw(&PathElement::new(ends.map(at), color.stroke_width(1)))?;
            }
            match self.mark {
                Mark::Dots => root.draw(&Circle::new(place, if small { 1 } else { 3 }, color.filled()))?,
                Mark::Curve => marker(root, k, place, color, point.hollow)?,
                _ => {}
            }
            if !point.label.is_empty() {
                words(root, &point.label, (place.0 + 8, place.1 - 9), 11)?;
            }
        }
        Ok(())
    }
}

/// A marker, whose shape is that of the `k`-th series: a disc, a square or a diamond.
fn marker(root: &Area<'_>, k: usize, (x, y): (i32, i32), color: RGBColor, hollow: bool) -> Drawn {
    let (sides, radius, turn) = [(24, 5.5, 0.0), (4, 7.0, 0.5), (4, 7.0, 0.0)][k % 3];
    let corner = |side: i32| {
        let angle = f64::from(side) * std::f64::consts::TAU / f64::from(sides) + turn * std::f64::consts::FRAC_PI_2;
        (x + (radius * angle.cos()).round() as i32, y + (radius * angle.sin()).round() as i32)
    };
    let outline: Vec<_> = (0..=sides).map(corner).collect();
    root.draw(&Polygon::new(outline.clone(), if hollow { WHITE.filled() } else { color.filled() }))?;
    Ok(root.draw(&PathElement::new(outline, color.stroke_width(2)))?)
}
