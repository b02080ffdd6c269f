//! Medians and ratios of samples, with their intervals.

use serde::Serialize;

use super::samples::{Samples, Series};
use crate::measure::statistics::{
    FEWEST, Interval, each_of, fewest_pairs, median, median_interval, paired_ratio, ratio_of_medians,
};

/// The confidence of a median's interval, and of all ratios of a comparison together.
pub const CONFIDENCE: f64 = 0.95;

/// One stage, the sum of all, or the whole frame, of two variants.
#[derive(Clone, Debug, Serialize)]
pub struct Ratio {
    /// The stage's name, `stages` for the sum of all, or `frame` for the time from call to result.
    pub what: String,
    /// Median milliseconds of the first and of the second; each interval of 95 %.
    pub ms: [Interval; 2],
    /// The second to the first; all intervals of a family, the edited stages or the other rows of a comparison, hold
    /// together with 95 %.
    pub ratio: Interval,
    /// About how many rounds are missing for an interval with two ends; 0 if it has them.
    pub missing_rounds: usize,
}

impl Ratio {
    /// What it shows: `slower` or `faster`; none if the interval holds 1.
    #[must_use]
    pub fn finding(&self) -> Option<&'static str> {
        self.ratio.excludes(1.0).then_some(if self.ratio.value > 1.0 { "slower" } else { "faster" })
    }

    /// What its cell of a table says: `slower`, `faster`, `undecided`, or nothing where no difference shows.
    #[must_use]
    pub fn shows(&self) -> &'static str {
        self.finding().unwrap_or(if self.missing_rounds > 0 { "undecided" } else { "" })
    }

    /// The largest change that the interval allows, as a share.
    #[must_use]
    pub fn hidden(&self) -> f64 {
        (self.ratio.high - 1.0).max(1.0 - self.ratio.low)
    }
}

/// The names that both series have, in the order of the first.
fn shared<'a>(first: &'a Series, other: &Series) -> Vec<&'a str> {
    first.names().filter(|name| other.names().any(|known| known == *name)).collect()
}

impl Samples {
    /// The median of one of a variant's stages, of `stages` or `frame`, and its interval of 95 %; where the variants
    /// were started several times, the median of the starts' medians.
    #[must_use]
    pub fn median(&self, variant: &Series, what: &str) -> Option<Interval> {
        let times = variant.times(what)?;
        Some(match self.starts(&times).as_slice() {
            [only] => median_interval(only, CONFIDENCE, self.seed),
            starts => {
                let medians: Vec<f64> = starts.iter().map(|start| median(start.to_vec())).collect();
                median_interval(&medians, CONFIDENCE, self.seed)
            }
        })
    }

    /// The medians of the first variant: of each stage, of `stages` and of `frame`.
    #[must_use]
    pub fn medians(&self) -> Vec<(&str, Interval)> {
        let Some(first) = self.variants.first() else { return Vec::new() };
        first.names().filter_map(|what| Some((what, self.median(first, what)?))).collect()
    }

    /// The names that only one of two series has.
    #[must_use]
    pub fn unshared(first: &Series, other: &Series) -> Vec<String> {
        let only = |one: &Series, two: &Series| -> Vec<String> {
            one.names().filter(|name| two.names().all(|known| known != *name)).map(String::from).collect()
        };
        [only(first, other), only(other, first)].concat()
    }

    /// Whether a row is an edited stage, and as such one of a family of its own.
    fn is_edited(&self, what: &str) -> bool {
        self.edited.iter().any(|stage| stage == what)
    }

    /// Number of ratios in the family of the edited stages, or of all other rows.
    fn family(&self, edited: bool) -> usize {
        let Some((first, others)) = self.variants.split_first() else { return 0 };
        let names = others.iter().flat_map(|other| shared(first, other));
        names.filter(|what| self.is_edited(what) == edited).count()
    }

    /// The confidence of a row's interval, so that all of its family hold together.
    fn confidence(&self, what: &str) -> f64 {
        each_of(CONFIDENCE, self.family(self.is_edited(what)))
    }

    /// The starts with which the edited stages, and all other rows, have intervals with two ends; 0 where there are
    /// none.
    #[must_use]
    pub fn fewest_starts(&self) -> [usize; 2] {
        [true, false].map(|edited| match self.family(edited) {
            0 => 0,
            count => fewest_pairs(each_of(CONFIDENCE, count)),
        })
    }

    /// Ratios of each variant but the first to the first one: the median of a start's rounds is one piece of evidence.
    /// A stage without a time in any round has none.
    #[must_use]
    pub fn ratios(&self) -> Vec<Vec<Ratio>> {
        let Some((first, others)) = self.variants.split_first() else { return Vec::new() };
        let starts = self.starts(&first.frame_ms).len();
        let row = |other: &Series, what: &str| {
            let confidence = self.confidence(what);
            let ratio = self.paired(first, other, what, confidence)?;
            let missing = fewest_pairs(confidence).saturating_sub(starts).max(1) * self.each;
            Some(Ratio {
                what: what.to_string(),
                ms: [self.median(first, what)?, self.median(other, what)?],
                ratio,
                missing_rounds: if ratio.high.is_finite() { 0 } else { missing },
            })
        };
        let all = |other| shared(first, other).into_iter().filter_map(|what| row(other, what)).collect();
        others.iter().map(all).collect()
    }

    fn paired(&self, first: &Series, other: &Series, what: &str, confidence: f64) -> Option<Interval> {
        let (before, after) = (first.times(what)?, other.times(what)?);
        let logs: Vec<f64> = before.iter().zip(&after).map(|(before, after)| (after / before).ln()).collect();
        let starts = self.starts(&logs).into_iter();
        let pairs: Vec<[f64; 2]> = starts.map(|start| [1.0, median(start.to_vec()).exp()]).collect();
        Some(paired_ratio(&pairs, confidence)).filter(|ratio| ratio.value.is_finite())
    }

    /// Ratios of another run's first variant to this one's: nothing pairs them, so that a difference between the two
    /// runs is one between the variants, too.
    #[must_use]
    pub fn against(&self, other: &Self) -> Vec<Ratio> {
        let (Some(one), Some(two)) = (self.variants.first(), other.variants.first()) else { return Vec::new() };
        let names = shared(one, two);
        let each = each_of(CONFIDENCE, names.len());
        let row = |what: &str| {
            let (before, after) = (self.kept(one, what)?, other.kept(two, what)?);
            let ratio = ratio_of_medians(&before, &after, each, self.seed);
            let ms = [self.median(one, what)?, other.median(two, what)?];
            let missing_rounds = FEWEST.saturating_sub(before.len().min(after.len()));
            Some(Ratio { what: what.to_string(), ms, ratio, missing_rounds }).filter(|row| row.ratio.value.is_finite())
        };
        names.into_iter().filter_map(row).collect()
    }

    /// The widest interval that matters, and half its width as a share of the value: of the ratios of several variants,
    /// of the medians of a single one. What matters is every stage that takes at least 2 % of the first variant's
    /// stages, and their sum; the frame where no stage has a time. `None` without samples.
    #[must_use]
    pub fn widest(&self) -> Option<(String, f64)> {
        let (first, others) = self.variants.split_first()?;
        let mut widths = Vec::new();
        for what in first.that_matter() {
            let found = match others {
                [] => vec![self.median(first, &what)],
                _ => others.iter().map(|other| self.paired(first, other, &what, self.confidence(&what))).collect(),
            };
            widths.extend(found.into_iter().flatten().map(|found| (what.clone(), found.half_width())));
        }
        widths.into_iter().filter(|(_, width)| !width.is_nan()).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}
