//! Seeded sampling of the receivers at which errors are measured, denser where radiosity is high: a sample that
//! misses the bright spot with most of the light would misjudge every relative error.

/// Sampled receivers and their weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// The faces, in ascending order, without repeats.
    pub faces: Vec<usize>,
    /// The area that each face stands for: its own area over its selection probability.
    pub areas: Vec<f64>,
    /// The number of faces that each face stands for: one over its selection probability.
    pub counts: Vec<f64>,
}

impl Sample {
    /// Samples about `count` of the faces with these areas, or all if there are fewer, by systematic sampling in face
    /// order. The selection probability follows the face count and the area (a quarter each) and the power `A B^2`
    /// over the channels (the other half), with `light` a rough estimate of the radiosity. Sums over the sample are
    /// unbiased for any `light`.
    #[must_use]
    pub fn seeded(areas: &[f64], light: &[[f64; 3]], count: usize, seed: u64) -> Self {
        let chance = chances(&wanted(areas, light), count);
        let mut at = uniform(seed);
        let mut chosen = Self::default();
        for (face, &chance) in chance.iter().enumerate() {
            at += chance;
            if at >= 1.0 || chance >= 1.0 {
                at -= 1.0;
                chosen.faces.push(face);
                chosen.areas.push(areas[face] / chance);
                chosen.counts.push(1.0 / chance);
            }
        }
        chosen
    }
}

/// Uniform in [0, 1), by one step of splitmix64.
fn uniform(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Sampling weight of each face, at least a quarter of the mean.
fn wanted(areas: &[f64], light: &[[f64; 3]]) -> Vec<f64> {
    let power = |face: usize, c: usize| {
        let value = light.get(face).map_or(0.0, |light| areas[face] * light[c] * light[c]);
        if value.is_finite() { value } else { 0.0 }
    };
    let share = |total: f64, value: f64| if total > 0.0 && total.is_finite() { value / total } else { 0.0 };
    let whole: f64 = areas.iter().sum();
    let powers = [0, 1, 2].map(|c| (0..areas.len()).map(|face| power(face, c)).sum::<f64>());
    let weight = |face: usize| {
        let lit: f64 = (0..3).map(|c| share(powers[c], power(face, c))).sum();
        0.25 / areas.len() as f64 + 0.25 * share(whole, areas[face]) + lit / 6.0
    };
    (0..areas.len()).map(weight).collect()
}

/// Selection probabilities proportional to the weights, at most 1 each, with sum `count`.
fn chances(wanted: &[f64], count: usize) -> Vec<f64> {
    if count >= wanted.len() {
        return vec![1.0; wanted.len()];
    }
    let at = |scale: f64| wanted.iter().map(move |w| (scale * w).min(1.0));
    let (mut low, mut high) = (0.0, 4.0 * (wanted.len() * wanted.len()) as f64);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if at(middle).sum::<f64>() > count as f64 { high = middle } else { low = middle }
    }
    at(high).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_seeded_and_has_no_repeats() {
        let sampled = |count, seed| Sample::seeded(&[1.0; 1000], &[], count, seed);
        assert_eq!(sampled(100, 7), sampled(100, 7));
        assert_ne!(sampled(100, 7).faces, sampled(100, 8).faces);
        let faces = sampled(100, 7).faces;
        assert!(faces.windows(2).all(|w| w[0] < w[1]) && (99..=101).contains(&faces.len()));
        let all = sampled(5000, 7);
        assert!(all.faces == (0..1000).collect::<Vec<_>>() && all.areas == [1.0; 1000] && all.counts == [1.0; 1000]);
        assert_eq!(Sample::seeded(&[], &[], 10, 1), Sample::default());
    }

    #[test]
    fn a_bright_spot_is_not_missed() {
        // Nearly all the power is on 20 of 100,000 faces, in one channel; every face has a little light in two
        // channels.
        let areas: Vec<f64> = (0..100_000).map(|k| 1.0 + f64::from(k % 7)).collect();
        let bright = |k: usize| (50_000..50_020).contains(&k);
        let light: Vec<[f64; 3]> = (0..areas.len()).map(|k| [if bright(k) { 1e3 } else { 1.0 }, 1.0, 0.0]).collect();
        let power: f64 = (0..areas.len()).map(|k| areas[k] * light[k][0] * light[k][0]).sum();
        for seed in 0..20 {
            let sample = Sample::seeded(&areas, &light, 400, seed);
            assert!(sample.faces.iter().filter(|&&k| bright(k)).count() >= 19);
            let found: f64 = sample.faces.iter().zip(&sample.areas).map(|(&k, a)| a * light[k][0] * light[k][0]).sum();
            assert!((found / power - 1.0).abs() < 0.05, "{found} {power}");
            let faces: f64 = sample.counts.iter().sum();
            assert!((faces / 1e5 - 1.0).abs() < 0.1, "{faces}");
        }
    }

    #[test]
    fn what_is_no_number_does_not_count() {
        let sample = Sample::seeded(&[1.0; 100], &[[f64::NAN, f64::INFINITY, 1.0]; 100], 10, 3);
        assert!((9..=11).contains(&sample.faces.len()) && sample.areas.iter().all(|a| a.is_finite()));
    }
}
