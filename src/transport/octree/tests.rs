//! The octree compared with the sum over all samples in `f64`.

use fearless_simd::Level;

use super::{Octree, Sample};
use crate::dipole::profile::Dipole;

/// Marble, in millimetres.
fn marble() -> [Dipole; 3] {
    [(2.19, 0.0021), (2.62, 0.0041), (3.00, 0.0071)].map(|(s, a)| Dipole::new(s, a, 3.954_7))
}

/// A bumpy ball of `count` samples and about 20 mm, lit from one side in three colours.
fn ball(count: usize) -> Vec<Sample> {
    let area = 4.0 * std::f32::consts::PI * 100.0 / count as f32;
    (0..count)
        .map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let normal = [(1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin];
            let radius = 9.0 + (5.0 * y).sin() * cos;
            let light = (0.6 * normal[0] + 0.8 * y).max(0.0);
            Sample { position: normal.map(|n| n * radius), area, irradiance: [light, light * light, light * (1.0 + y)] }
        })
        .collect()
}

fn positions(samples: &[Sample]) -> Vec<[f32; 3]> {
    samples.iter().map(|sample| sample.position).collect()
}

fn sum(samples: &[Sample], dipoles: &[Dipole; 3], at: [f32; 3]) -> [f64; 3] {
    let mut radiosity = [0.0; 3];
    for sample in samples {
        let d2 = (0..3).map(|k| (f64::from(sample.position[k]) - f64::from(at[k])).powi(2)).sum();
        for k in 0..3 {
            radiosity[k] += f64::from(sample.area) * f64::from(sample.irradiance[k]) * dipoles[k].radial(d2);
        }
    }
    radiosity
}

/// Every instruction set that this processor has.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = vec![best];
    #[cfg(target_arch = "x86_64")]
    levels.extend(best.as_avx2().map(Level::Avx2).into_iter().chain(best.as_sse4_2().map(Level::Sse4_2)));
    levels
}

/// Largest relative error over the receivers and channels.
fn error(samples: &[Sample], dipoles: &[Dipole; 3], level: Level, threshold: f32, receivers: &[[f32; 3]]) -> f64 {
    let radiosity = Octree::new(samples).gather_at(level, dipoles, threshold, receivers);
    let mut worst = 0.0f64;
    for (own, &at) in radiosity.iter().zip(receivers) {
        let exact = sum(samples, dipoles, at);
        for k in 0..3 {
            worst = worst.max((f64::from(own[k]) / exact[k] - 1.0).abs());
        }
    }
    worst
}

#[test]
fn threshold_zero_is_the_sum_over_all_samples() {
    let samples = ball(3000);
    let receivers: Vec<_> = positions(&samples).into_iter().step_by(7).collect();
    // One material without absorption, and one so dense that there is no table.
    let clear = [(2.0, 0.0), (3.0, 0.0), (2.5, 0.01)].map(|(s, a)| Dipole::new(s, a, 3.0));
    let dense = [(50.0, 0.5), (60.0, 0.0), (70.0, 0.1)].map(|(s, a)| Dipole::new(s, a, 2.5));
    for level in levels() {
        for dipoles in [marble(), clear, dense] {
            // Radiosity too small for `f32` is lost: compare only where there is light.
            let lit: Vec<_> = receivers
                .iter()
                .copied()
                .filter(|&at| sum(&samples, &dipoles, at).iter().all(|&radiosity| radiosity > 1e-20))
                .collect();
            assert!(lit.len() > 100);
            let worst = error(&samples, &dipoles, level, 0.0, &lit);
            assert!(worst < 1e-5, "{level:?} {dipoles:?}: {worst:e}");
        }
    }
}

#[test]
fn a_smaller_threshold_gives_a_smaller_error() {
    let samples = ball(20_000);
    let receivers: Vec<_> = positions(&samples).into_iter().step_by(41).collect();
    let tree = Octree::new(&samples);
    let exact: Vec<_> = receivers.iter().map(|&at| sum(&samples, &marble(), at)).collect();
    let errors = [0.8, 0.2, 0.05].map(|threshold| {
        let own = tree.gather(&marble(), threshold, &receivers);
        let off = |k: usize| own.iter().zip(&exact).map(|(a, b)| (f64::from(a[k]) - b[k]).powi(2)).sum::<f64>();
        (0..3).map(off).sum::<f64>()
    });
    assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[2] > 0.0, "{errors:?}");
}

#[test]
fn nothing_comes_of_nothing() {
    let dark: Vec<_> = ball(500).into_iter().map(|sample| Sample { irradiance: [0.0; 3], ..sample }).collect();
    assert_eq!(Octree::new(&dark).gather(&marble(), 0.1, &positions(&dark)), vec![[0.0; 3]; 500]);
    assert_eq!(Octree::new(&[]).gather(&marble(), 0.1, &[[1.0; 3]]), [[0.0; 3]]);
    assert!(Octree::new(&ball(50)).gather(&marble(), 0.1, &[]).is_empty());
}

#[test]
fn samples_in_one_place_share_a_leaf() {
    let one = Sample { position: [1.0, 2.0, 3.0], area: 0.5, irradiance: [1.0, 0.5, 0.25] };
    let mut samples = vec![one; 1000];
    let receivers = [one.position, [1.5, 2.0, 3.0]];
    assert!(error(&samples, &marble(), Level::new(), 0.1, &receivers) < 1e-5);
    samples.push(Sample { position: [9.0, 2.0, 3.0], ..one });
    assert!(error(&samples, &marble(), Level::new(), 0.0, &receivers) < 1e-5);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let samples = ball(20_000);
    let receivers = positions(&samples);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Octree::new(&samples).gather(&marble(), 0.2, &receivers))
    };
    let alone = run(1);
    assert_eq!(alone, run(2));
    assert_eq!(alone, run(5));
}

#[cfg(target_arch = "x86_64")]
#[test]
fn marble_of_the_usual_size_has_a_table() {
    assert!(super::table::Table::new(&marble(), 30f64.powi(2)).is_some());
    assert!(super::table::Table::new(&marble(), 300f64.powi(2)).is_none());
}
