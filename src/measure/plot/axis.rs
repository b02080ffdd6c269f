//! The axes of a panel: what they show, and where they have labels.

use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;

/// An axis.
#[derive(Clone, Default)]
pub struct Axis {
    pub(super) label: String,
    pub(super) log: bool,
    ends: Option<[f64; 2]>,
    pub(super) names: Vec<String>,
}

impl Axis {
    /// A linear axis: its label, with the unit.
    #[must_use]
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// A logarithmic axis; it shows positive numbers only.
    #[must_use]
    pub fn log(label: &str) -> Self {
        Self { log: true, ..Self::linear(label) }
    }

    /// An axis with names at 0, 1, 2 and so on, the first at its far end.
    #[must_use]
    pub fn names(names: Vec<String>) -> Self {
        Self { ends: Some([names.len() as f64 - 0.5, -0.5]), names, ..Self::default() }
    }

    /// The same axis with these ends; without ends it shows all points.
    #[must_use]
    pub fn within(self, ends: [f64; 2]) -> Self {
        Self { ends: Some(ends), ..self }
    }

    /// Whether a number has a place on the axis.
    pub(super) fn shows(&self, number: f64) -> bool {
        number.is_finite() && !(self.log && number <= 0.0)
    }

    /// The ends of the axis: its own, or such that it shows these numbers with a margin, a logarithmic axis at least a
    /// decade.
    pub(super) fn range(&self, numbers: impl Iterator<Item = f64>) -> [f64; 2] {
        let all = numbers.filter(|number| self.shows(*number));
        let all = all.map(|number| if self.log { number.log10() } else { number });
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        match (self.ends, low > high, self.log) {
            (Some(ends), ..) => ends,
            (_, true, true) => [1.0, 10.0],
            (_, true, false) => [0.0, 1.0],
            (_, _, true) => {
                let margin = (0.06 * (high - low)).max(0.5 * (1.0 - (high - low))).max(0.1);
                [low - margin, high + margin].map(|power| 10f64.powf(power))
            }
            (_, _, false) => {
                let margin = 0.04 * (high - low).max(1e-9 * high.abs()).max(1e-300);
                // Start at 0 if that is near.
                let start = if low >= 0.0 && low < 0.3 * high { 0.0 } else { low - margin };
                [start, high + margin]
            }
        }
    }

    /// The numbers between these ends that have a label, and those that have a line only.
    pub(super) fn ticks(&self, [low, high]: [f64; 2]) -> [Vec<f64>; 2] {
        if !self.names.is_empty() {
            return [(0..self.names.len()).map(|k| k as f64).collect(), Vec::new()];
        }
        if !self.log {
            return [RangedCoordf64::from(low..high).key_points(8), Vec::new()];
        }
        let few = (high / low).log10() < 2.5;
        let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let all = powers.flat_map(|power| (1..10).map(move |digit| (digit, format!("{digit}e{power}"))));
        // Parsed from text, a number prints the same.
        let all = all.map(|(digit, text)| (digit, text.parse().unwrap_or(f64::NAN)));
        let (labelled, others): (Vec<_>, Vec<_>) = all
            .filter(|(_, number)| (low..=high).contains(number))
            .partition(|(digit, _)| *digit == 1 || few && [2, 5].contains(digit));
        [labelled, others].map(|list| list.into_iter().map(|(_, number)| number).collect())
    }

    /// A number's label, with an exponent if it would be long.
    pub(super) fn name(&self, number: f64) -> String {
        if let Some(name) = self.names.get(number as usize) {
            return name.clone();
        }
        let number: f64 = format!("{number:.3e}").parse().unwrap_or(number);
        let plain = if self.log { 0.1..1e5 } else { 0.01..1e4 };
        if number == 0.0 || plain.contains(&number.abs()) { number.to_string() } else { format!("{number:e}") }
    }
}
