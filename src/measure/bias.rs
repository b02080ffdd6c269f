//! Systematic error: the mean of the signed relative differences between device and reference.
//!
//! Tolerances are of single values, and wide where a value may cancel. An error that leans to one side may hide in
//! them: a factor of 1 + 3e-5 is 500 times the rounding of a float. The rounding of many values goes either way, and
//! its mean is far smaller.

use serde::{Deserialize, Serialize};

/// A relative difference counts for this much at most: few values near 0, of which only the absolute difference
/// means something, do not decide.
const MOST: f64 = 1e-4;
/// Values below this share of the largest of their field are left out, for the same reason.
const LEAST: f64 = 1e-4;
/// Fewer values say nothing about their mean.
const ENOUGH: u64 = 64;
/// Standard errors that the mean of values with random errors may be off.
const LUCK: f64 = 5.0;
/// The largest mean that counts as rounding. Two sound drivers, llvmpipe and SwiftShader, show at most 9e-7 over all
/// fixtures (`cdrf`), and 5e-7 or less in all stages but two; others may have a coarser `exp`.
pub const ALLOWED: f64 = 2e-6;

/// The signed relative differences of one field of a buffer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// The buffer.
    pub buffer: String,
    /// The field; empty for a buffer of plain numbers.
    pub field: String,
    /// Number of values that differ: values that a stage leaves as they are would water the mean down.
    pub count: u64,
    /// Sum of their signed relative differences.
    pub sum: f64,
    /// Sum of the squares of their relative differences.
    pub squares: f64,
}

impl Bias {
    /// The differences of `pairs`, reference and device, of a field.
    pub fn of(buffer: &str, field: &str, pairs: impl Iterator<Item = (f32, f32)> + Clone) -> Self {
        let largest = pairs.clone().map(|(p, _)| f64::from(p).abs()).filter(|p| p.is_finite()).fold(0.0, f64::max);
        let mut bias = Self { buffer: buffer.into(), field: field.into(), ..Self::default() };
        for (p, q) in pairs.map(|(p, q)| (f64::from(p), f64::from(q))) {
            if p != q && p != 0.0 && p.abs() >= LEAST * largest && p.is_finite() && q.is_finite() {
                let off = ((q - p) / p).clamp(-MOST, MOST);
                bias.count += 1;
                bias.sum += off;
                bias.squares += off * off;
            }
        }
        bias
    }

    /// The mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    /// The standard error of the mean.
    #[must_use]
    pub fn error(&self) -> f64 {
        let count = self.count.max(1) as f64;
        (self.squares / count - self.mean().powi(2)).max(0.0).sqrt() / count.sqrt()
    }

    /// Whether the mean is more than rounding and luck.
    #[must_use]
    pub fn leans(&self) -> bool {
        self.count >= ENOUGH && self.mean().abs() > ALLOWED + LUCK * self.error()
    }

    /// The field's name after that of its buffer.
    #[must_use]
    pub fn place(&self) -> String {
        let dot = if self.field.is_empty() { "" } else { "." };
        format!("{}{dot}{}", self.buffer, self.field)
    }

    /// What is wrong, in words.
    pub fn fault(&self, place: &str) -> String {
        format!(
            "{place}{} is off by {:+.1e} of itself in the mean of {} values; rounding stays below {ALLOWED:.0e}",
            self.place(),
            self.mean(),
            self.count
        )
    }
}

/// Adds up the differences of several comparisons, field by field.
pub fn add(sums: &mut Vec<Bias>, more: &[Bias]) {
    for bias in more {
        match sums.iter_mut().find(|sum| sum.buffer == bias.buffer && sum.field == bias.field) {
            Some(sum) => {
                sum.count += bias.count;
                sum.sum += bias.sum;
                sum.squares += bias.squares;
            }
            None => sums.push(bias.clone()),
        }
    }
}

/// The mean that is farthest from 0, of fields with enough values; `None` where there is none.
#[must_use]
pub fn farthest(biases: &[Bias]) -> Option<f64> {
    let means = biases.iter().filter(|bias| bias.count >= ENOUGH).map(Bias::mean);
    means.max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values from 0.5 to 1.5, and what a device makes of them.
    fn pairs(device: impl Fn(usize, f32) -> f32) -> Bias {
        let pairs: Vec<(f32, f32)> = (0..2000)
            .map(|k| {
                let value = 0.5 + (k * 7919 % 2000) as f32 / 2000.0;
                (value, device(k, value))
            })
            .collect();
        Bias::of("radiosity", "", pairs.into_iter())
    }

    #[test]
    fn a_factor_leans_and_rounding_does_not() {
        assert!(pairs(|_, x| x * (1.0 + 3e-5)).leans());
        assert!(pairs(|_, x| x * (1.0 - 3e-5)).leans());
        // In every twentieth value, too.
        assert!(pairs(|k, x| if k % 20 == 0 { x * (1.0 + 3e-5) } else { x }).leans());
        assert!(!pairs(|_, x| x).leans());
        // Errors to either side, and a few large ones.
        assert!(!pairs(|k, x| if k % 2 == 0 { x * (1.0 + 2e-5) } else { x * (1.0 - 2e-5) }).leans());
        assert!(!pairs(|k, x| if k % 1000 == 0 { 2.0 * x } else { x }).leans());
        // Too few to tell, and values near 0.
        let few: Vec<(f32, f32)> = (0..40).map(|_| (1.0, 1.0001)).collect();
        assert!(!Bias::of("radiosity", "", few.into_iter()).leans());
        let near_0 = (0..2000).map(|k| if k == 0 { (1.0, 1.0) } else { (1e-5_f32, 1.1e-5_f32) });
        assert!(!Bias::of("radiosity", "", near_0).leans());
    }
}
