//! Logarithmic axes: range, ticks, labels, and the position of a point.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The result of drawing.
pub type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Colour of text and frames.
pub const INK: RGBColor = RGBColor(40, 40, 40);
/// Colour of secondary text.
pub const FAINT: RGBColor = RGBColor(105, 105, 105);
const DECADE: RGBColor = RGBColor(205, 205, 205);
const MINOR: RGBColor = RGBColor(238, 238, 238);

/// Space between a panel's edge and its axes: left, right, top, bottom, pixels.
const MARGIN: [i32; 4] = [78, 18, 34, 58];

/// The ranges of both axes, as powers of ten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    x: [f64; 2],
    y: [f64; 2],
}

impl Axes {
    /// Ranges around these points, whose coordinates are positive, with a margin, and at least one decade each.
    pub fn around(points: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        Self { x: range(points.clone().map(|p| p.0)), y: range(points.map(|p| p.1)) }
    }
}

/// The range around positive numbers, as powers of ten.
fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) =
        numbers.map(f64::log10).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    if low > high {
        return [0.0, 1.0];
    }
    let margin = (0.08 * (high - low)).max(0.5 * (1.0 - (high - low))).max(0.1);
    [low - margin, high + margin]
}

/// The ticks of a range: the number, whether it is a power of ten, and whether it has a label.
fn ticks([low, high]: [f64; 2]) -> Vec<(f64, bool, bool)> {
    let few = high - low < 2.5;
    let mut list = Vec::new();
    for power in low.floor() as i32..=high.ceil() as i32 {
        for digit in 1..10 {
            // Parse from text, so that the number prints the same.
            let number: f64 = format!("{digit}e{power}").parse().unwrap_or(f64::NAN);
            if (low..=high).contains(&number.log10()) {
                list.push((number, digit == 1, digit == 1 || few && (digit == 2 || digit == 5)));
            }
        }
    }
    list
}

/// A number on an axis, with an exponent if it would be long.
fn short(number: f64) -> String {
    if (0.1..1e5).contains(&number) { number.to_string() } else { format!("{number:e}") }
}

/// Draws text, vertically centred at this position.
pub fn text<DB: DrawingBackend>(
    root: &DrawingArea<DB, Shift>,
    words: &str,
    at: (i32, i32),
    size: i32,
    color: &RGBColor,
    horizontal: HPos,
) -> Drawn<DB> {
    let style = ("sans-serif", size).into_font().color(color).pos(Pos::new(horizontal, VPos::Center));
    root.draw_text(words, &style, at)
}

/// A panel with axes in the picture.
pub struct Canvas<'a, DB: DrawingBackend> {
    /// The picture.
    pub root: &'a DrawingArea<DB, Shift>,
    axes: Axes,
    /// Left, right, top and bottom of the plotting area, pixels.
    plane: [i32; 4],
}

impl<'a, DB: DrawingBackend> Canvas<'a, DB> {
    /// A panel with this top left corner and size.
    pub fn new(root: &'a DrawingArea<DB, Shift>, axes: Axes, corner: (i32, i32), size: [i32; 2]) -> Self {
        let [left, right, top, bottom] = MARGIN;
        let plane = [corner.0 + left, corner.0 + size[0] - right, corner.1 + top, corner.1 + size[1] - bottom];
        Self { root, axes, plane }
    }

    /// The pixel of a point.
    pub fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        let [left, right, top, bottom] = self.plane.map(f64::from);
        let share = |[low, high]: [f64; 2], number: f64| (number.log10() - low) / (high - low);
        let across = left + share(self.axes.x, x) * (right - left);
        let up = bottom - share(self.axes.y, y) * (bottom - top);
        (across.round() as i32, up.round() as i32)
    }

    /// Draws grid, ticks, labels and headings.
    pub fn frame(&self, heading: &str, yardstick: &str) -> Drawn<DB> {
        let [left, right, top, bottom] = self.plane;
        let (x_ticks, y_ticks) = (ticks(self.axes.x), ticks(self.axes.y));
        for decades in [false, true] {
            let style = if decades { DECADE } else { MINOR }.stroke_width(1);
            for &(number, ..) in x_ticks.iter().filter(|tick| tick.1 == decades) {
                let (x, _) = self.at((number, 1.0));
                self.root.draw(&PathElement::new(vec![(x, top), (x, bottom)], style))?;
            }
            for &(number, ..) in y_ticks.iter().filter(|tick| tick.1 == decades) {
                let (_, y) = self.at((1.0, number));
                self.root.draw(&PathElement::new(vec![(left, y), (right, y)], style))?;
            }
        }
        self.root.draw(&Rectangle::new([(left, top), (right, bottom)], INK.stroke_width(1)))?;
        for &(number, ..) in x_ticks.iter().filter(|tick| tick.2) {
            let (x, _) = self.at((number, 1.0));
            text(self.root, &short(number), (x, bottom + 15), 13, &INK, HPos::Center)?;
        }
        for &(number, ..) in y_ticks.iter().filter(|tick| tick.2) {
            let (_, y) = self.at((1.0, number));
            text(self.root, &short(number), (left - 8, y), 13, &INK, HPos::Right)?;
        }
        let middle = (left + right) / 2;
        text(self.root, heading, (middle, top - 16), 16, &INK, HPos::Center)?;
        text(self.root, "time a frame, ms", (middle, bottom + 38), 13, &INK, HPos::Center)?;
        let upward = ("sans-serif", 13).into_font().transform(FontTransform::Rotate270).color(&INK);
        let upward = upward.pos(Pos::new(HPos::Center, VPos::Center));
        self.root.draw_text(&format!("L2 {yardstick}"), &upward, (left - 60, (top + bottom) / 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_their_numbers_and_at_least_a_decade() {
        let [low, high] = range([3.0, 5.0].into_iter());
        assert!(low < 3f64.log10() && high > 5f64.log10() && high - low >= 1.0);
        assert_eq!(range(std::iter::empty()), [0.0, 1.0]);
    }

    #[test]
    fn labelled_ticks_are_round() {
        let labelled = |range| ticks(range).into_iter().filter(|t| t.2).map(|t| short(t.0)).collect::<Vec<_>>();
        assert_eq!(labelled([0.9, 2.1]), ["10", "20", "50", "100"]);
        assert_eq!(labelled([-5.0, -1.5]), ["1e-5", "1e-4", "1e-3", "1e-2"]);
    }
}
