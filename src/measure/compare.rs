//! Word-by-word comparison of one buffer in two states, for conformance.

use super::bias::{Bias, add};
use super::pattern::pattern;
use super::rules::{Allowed, Rules, field_of};
use crate::layout::{BufferId, Number, Word};
use crate::state::{State, Tolerance};

/// Upper bounds, in units in the last place, of all but the last bin of [`Distances::histogram`].
pub const BINS: [u64; 7] = [0, 1, 3, 7, 15, 255, 65_535];

/// Distances beyond this, in units in the last place, are explained where they are within tolerance.
const FAR: u64 = 255;

/// How far the device's values are from the reference's.
#[derive(Clone, Debug, Default)]
pub struct Distances {
    /// Words compared.
    pub words: usize,
    /// Largest distance over all floats, units in the last place.
    pub ulp: u64,
    /// Number of floats per distance: one bin for each of [`BINS`], and one for larger distances.
    pub histogram: [u64; 8],
    /// Largest |difference| / max(|reference|, floor), with the tolerance's floor for that field, over all floats.
    pub relative: f64,
    /// Largest |difference| / allowed difference over all floats: up to 1 it is within tolerance.
    pub used: f64,
    /// The signed relative differences of each field.
    pub biases: Vec<Bias>,
    /// The float of the largest distance, and why it may be that far off; none if its own size allows that.
    pub farthest: Option<String>,
}

/// Differences between one buffer of the device and the reference's.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// The distances of all values.
    pub distances: Distances,
    /// Words beyond the tolerance.
    pub failures: usize,
    /// The first failure as text: index, field, both values, both in hex.
    pub first: Option<String>,
    /// The failure that is farthest beyond what is allowed, where it is not the first.
    pub worst: Option<String>,
    /// Where the failures are.
    pub places: String,
}

/// Distance between two floats in units in the last place; `u64::MAX` if either is NaN.
fn ulp(a: f32, b: f32) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::MAX;
    }
    let order = |x: f32| {
        let bits = i64::from(x.to_bits() & 0x7fff_ffff);
        if x.is_sign_negative() { -bits } else { bits }
    };
    order(a).abs_diff(order(b))
}

/// Whether two words of a float are the same: the same bits, or, where a value has a tolerance, NaN in both. What is
/// computed from poison is not a number, with bits of the processor's choice.
fn same(x: u32, y: u32, has_tolerance: impl FnOnce() -> bool) -> bool {
    x == y || (f32::from_bits(x).is_nan() && f32::from_bits(y).is_nan() && has_tolerance())
}

/// Compares one buffer of two states. Failures and relative differences cover the whole buffer; the word count, the
/// biases and the distances in ulp only `part`, given as first element and number of elements.
pub fn compare(
    slot: BufferId,
    reference: &State,
    device: &State,
    tolerance: Tolerance,
    part: (usize, usize),
) -> Comparison {
    let both = Both {
        slot,
        layout: (slot.spec().words)(),
        reference: bytemuck::cast_slice(reference.data.bytes(slot)),
        device: bytemuck::cast_slice(device.data.bytes(slot)),
    };
    let (a, b, layout) = (both.reference, both.device, &both.layout);
    let mut result = Comparison::default();
    result.distances.words = part.1 * layout.len();
    if a.len() != b.len() {
        result.failures = a.len().abs_diff(b.len());
        result.first = Some(format!("{} words on the device, {} expected", b.len(), a.len()));
        return result;
    }
    if part.1 > 0 && tolerance != Tolerance::Exact {
        result.distances.biases = both.biases(part);
    }
    if a == b {
        result.distances.histogram[0] = (part.1 * both.floats().count()) as u64;
        return result;
    }
    let rules = Rules::new(slot, reference, tolerance);

    let (mut wrong, mut worst, mut farthest) = (Vec::new(), (0, 0.0), 0);
    for (i, (&x, &y)) in a.iter().zip(b).enumerate() {
        let float = layout[i % layout.len()].number == Number::Float;
        let equal = if float { same(x, y, || rules.at(i).most.is_some()) } else { x == y };
        if float && (part.0..part.0 + part.1).contains(&(i / layout.len())) {
            let distance = if equal { 0 } else { ulp(f32::from_bits(x), f32::from_bits(y)) };
            result.distances.histogram[BINS.iter().take_while(|most| distance > **most).count()] += 1;
            if distance > result.distances.ulp {
                (result.distances.ulp, farthest) = (distance, i);
            }
        }
        let (passes, beyond) = if float && !equal { result.distances.hold([x, y], rules.at(i)) } else { (equal, 0.0) };
        if !passes {
            if wrong.is_empty() || beyond > worst.1 || (f64::is_nan(beyond) && !f64::is_nan(worst.1)) {
                worst = (i, beyond);
            }
            wrong.push(i);
        }
    }
    result.failures = wrong.len();
    result.first = wrong.first().map(|&first| both.told(first));
    if result.distances.ulp > FAR && wrong.is_empty() {
        result.distances.farthest = rules.at(farthest).beside_its_share().map(|why| {
            let off = (f64::from(f32::from_bits(b[farthest])) - f64::from(f32::from_bits(a[farthest]))).abs();
            format!("{}: off by {off:.1e}, {why}", both.told(farthest))
        });
    }
    if let Some(first) = wrong.first() {
        result.worst = (worst.0 != *first).then(|| both.told(worst.0));
        result.places = pattern(&wrong, layout, part);
    }
    result
}

impl Distances {
    /// Adds those of more values.
    pub fn add(&mut self, more: Self) {
        self.words += more.words;
        if more.ulp > self.ulp {
            (self.ulp, self.farthest) = (more.ulp, more.farthest);
        }
        self.histogram.iter_mut().zip(more.histogram).for_each(|(sum, count)| *sum += count);
        self.relative = self.relative.max(more.relative);
        self.used = self.used.max(more.used);
        add(&mut self.biases, &more.biases);
    }

    /// Whether two floats that differ are within what is allowed, and by which factor the difference exceeds that.
    fn hold(&mut self, words: [u32; 2], Allowed { lowest, most, .. }: Allowed) -> (bool, f64) {
        let [p, q] = words.map(f32::from_bits);
        let difference = (f64::from(p) - f64::from(q)).abs();
        let allowed = most.unwrap_or(0.0);
        let relative = difference / f64::from(p).abs().max(lowest).max(1e-38);
        // NaN and infinity count as infinitely far off.
        self.relative = self.relative.max(if relative.is_nan() { f64::INFINITY } else { relative });
        let used = if difference == 0.0 && allowed > 0.0 { 0.0 } else { difference / allowed };
        self.used = self.used.max(if used.is_nan() { f64::INFINITY } else { used });
        // Without a rule the bits must agree: 0 and -0 differ.
        let passes = most.is_some() && p.is_finite() && q.is_finite() && difference <= allowed;
        (passes, difference / allowed.max(1e-38))
    }
}

/// A buffer on both sides.
struct Both<'a> {
    slot: BufferId,
    layout: Vec<Word>,
    reference: &'a [u32],
    device: &'a [u32],
}

impl Both<'_> {
    /// The words of an element that are floats.
    fn floats(&self) -> impl Iterator<Item = usize> {
        (0..self.layout.len()).filter(|&k| self.layout[k].number == Number::Float)
    }

    /// The signed differences of each field in a part of the buffer.
    fn biases(&self, part: (usize, usize)) -> Vec<Bias> {
        let length = self.layout.len();
        let group = |k: usize| field_of(&self.layout[k].path);
        let range = part.0 * length..(part.0 + part.1) * length;
        let starts = self.floats().filter(|&k| (0..k).all(|j| group(j) != group(k)));
        starts
            .map(|k| {
                let words = range.clone().filter(|i| group(i % length) == group(k));
                let pairs = words.map(|i| (f32::from_bits(self.reference[i]), f32::from_bits(self.device[i])));
                Bias::of(self.slot.spec().name, group(k), pairs)
            })
            .collect()
    }

    /// A word on both sides, as text.
    fn told(&self, i: usize) -> String {
        let word = &self.layout[i % self.layout.len()];
        let show = |bits: u32| match word.number {
            Number::Float => format!("{:e} ({bits:#010x})", f32::from_bits(bits)),
            Number::Unsigned => format!("{bits} ({bits:#010x})"),
        };
        let dot = if word.path.is_empty() { "" } else { "." };
        let (name, element) = (self.slot.spec().name, i / self.layout.len());
        let [reference, device] = [self.reference[i], self.device[i]].map(show);
        format!("{name}[{element}]{dot}{}: reference {reference}, device {device}", word.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::refit;
    use crate::measure::fixtures::fixtures;
    use crate::state::{Scope, Step};

    fn state(radiosity: Vec<[f32; 3]>) -> State {
        let mut state = State::default();
        state.data.radiosity = radiosity;
        state
    }

    #[test]
    fn a_difference_is_found_and_named() {
        let reference = state(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let device = state(vec![[1.0, 2.0, 3.0], [4.0, 5.001, 6.0]]);
        let tight = Tolerance::Float { relative: 1e-5, floor: 0.0 };
        let found = compare(BufferId::radiosity, &reference, &device, tight, (0, 2));
        assert_eq!((found.distances.words, found.failures), (6, 1));
        assert!((found.distances.used - 20.0).abs() < 0.1, "{}", found.distances.used);
        assert_eq!(found.distances.histogram, [5, 0, 0, 0, 0, 0, 1, 0]);
        assert!(
            found.first.as_ref().is_some_and(|text| text.starts_with("radiosity[1].1: reference 5e0 (0x40a00000)"))
        );
        let loose = Tolerance::Float { relative: 1e-3, floor: 0.0 };
        let within = compare(BufferId::radiosity, &reference, &device, loose, (0, 2));
        assert!(within.failures == 0 && (within.distances.used - 0.2).abs() < 0.001, "{}", within.distances.used);
        assert_eq!(compare(BufferId::radiosity, &reference, &device, Tolerance::Exact, (0, 2)).failures, 1);
    }

    #[test]
    fn no_number_is_never_within_tolerance() {
        let tolerance = Tolerance::Float { relative: 1.0, floor: 1.0 };
        let found =
            compare(BufferId::radiosity, &state(vec![[1.0; 3]]), &state(vec![[1.0, f32::NAN, 1.0]]), tolerance, (0, 1));
        assert_eq!(found.failures, 1);
        assert_eq!(found.distances.ulp, u64::MAX);
        // What is computed from poison is not a number on any processor, in bits of its own.
        let [poison, own] = [0xffc0_dead, 0x7fff_ffff].map(|bits| state(vec![[1.0, f32::from_bits(bits), 1.0]]));
        let failures = |tolerance| compare(BufferId::radiosity, &poison, &own, tolerance, (0, 1)).failures;
        assert_eq!((failures(tolerance), failures(Tolerance::Exact)), (0, 1));
    }

    #[test]
    fn a_float_that_is_far_off_and_conforms_explains_itself() {
        let (near, far) = (state(vec![[1.0, 1e-9, 1.0]]), state(vec![[1.0, 2e-9, 1.0]]));
        let found = |floor| {
            let tolerance = Tolerance::Float { relative: 1e-5, floor };
            compare(BufferId::radiosity, &near, &far, tolerance, (0, 1))
        };
        let text = found(1e-6).distances.farthest.unwrap();
        assert!(text.starts_with("radiosity[0].1: reference 1e-9 (0x3089705f), device 2e-9"), "{text}");
        assert!(text.ends_with("off by 1.0e-9, allowed 1.0e-6, 1.0e-6 of it by the floor"), "{text}");
        // A failure has words of its own.
        assert!(found(1e-12).distances.farthest.is_none());
        let by_share = Allowed { lowest: 1e-9, rounding: 0.0, most: Some(1e-5) };
        assert_eq!(by_share.beside_its_share(), None);
        let rounded = Allowed { lowest: 1e-9, rounding: 1e-5, most: Some(1e-5) };
        assert!(rounded.beside_its_share().unwrap().contains("by the rounding of its own element"));
    }

    #[test]
    fn the_rounding_of_a_sliver_excuses_no_other_triangle() {
        let mut fixture = fixtures("oblique slivers").unwrap().swap_remove(0);
        Step { stage: &refit::STAGE, at: Scope::default() }.reference(&mut fixture.state);
        let reference = fixture.state;
        let slot = BufferId::clusters;
        let (.., tolerance) = *refit::STAGE.writes.iter().find(|written| written.0 == slot).unwrap();
        let failures = |leaf: u32, factor: f32| {
            let mut device = reference.clone();
            device.data.clusters[leaf as usize].area *= factor;
            compare(slot, &reference, &device, tolerance, (0, 1)).failures
        };
        let (mut slivers, mut others) = (0, 0);
        for &leaf in &reference.data.leaves {
            let cluster = &reference.data.clusters[leaf as usize];
            if cluster.area > cluster.moment_trace {
                assert_eq!((failures(leaf, 1.0 + 1e-5), failures(leaf, 1.0 + 1e-6)), (1, 0), "{cluster:?}");
                others += 1;
            } else if cluster.area < 2e-4 * cluster.moment_trace {
                assert_eq!((failures(leaf, 1.1), failures(leaf, 1.0 + 1e-4)), (1, 0), "{cluster:?}");
                slivers += 1;
            }
        }
        assert!(slivers > 2 && others > 5, "{slivers} slivers, {others} other triangles");
    }

    #[test]
    fn units_in_the_last_place() {
        assert_eq!(ulp(1.0, 1.0), 0);
        assert_eq!(ulp(1.0, f32::from_bits(1.0f32.to_bits() + 3)), 3);
        assert_eq!(ulp(0.0, -0.0), 0);
        assert_eq!(ulp(f32::from_bits(1), -f32::from_bits(2)), 3);
    }
}
