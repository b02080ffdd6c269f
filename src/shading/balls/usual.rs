//! sigma_0 of a material that does not name one: the fit to the dipole over balls of the usual radii, computed once for
//! all materials with the same shares and boundary, and kept.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use rayon::prelude::*;

use super::dipole::curve;
use super::fit::fit;
use super::{PATHS, radii};
use crate::dipole::profile::Dipole;

/// The most mean free paths that [`spread`] returns.
pub const WIDEST: f64 = 10.0;

/// The standard deviation, along one axis, of the dipole's profile, sqrt(z / sigma_tr), with z the mean of the sources'
/// depths weighted by the light of each. Length; at most [`WIDEST`] mean free paths, since at low absorption the
/// profile's far tail dominates. The fit starts its search here.
#[must_use]
pub fn spread(dipole: &Dipole) -> f64 {
    let weights = dipole.depths().map(|z| (-dipole.sigma * z).exp());
    let mean = (weights[0] * dipole.z_real + weights[1] * dipole.z_virtual) / (weights[0] + weights[1]);
    (mean / dipole.sigma).sqrt().min(WIDEST * dipole.z_real)
}

/// The inputs of a channel's fit, as bits: the shares of scattering and absorption in the extinction, the boundary's A,
/// and the balls' radii, as a factor on the usual multiples of its mean free path.
type Key = [u64; 4];

/// The most fits that are kept. A sequence that changes its materials in every frame must not fill the memory.
const MOST: usize = 4096;

/// sigma_0 of each channel, length, from coefficients in 1/length and the A of each channel's boundary. Coefficients
/// are at least 0, not both 0 in a channel.
#[must_use]
pub fn fitted(sigma_s_prime: [f64; 3], sigma_a: [f64; 3], boundary: [f64; 3]) -> [f64; 3] {
    static KEPT: OnceLock<Kept> = OnceLock::new();
    let paths = [0, 1, 2].map(|c| 1.0 / (sigma_s_prime[c] + sigma_a[c]));
    let shares = [0, 1, 2].map(|c| {
        let factor = radii(paths, c)[0] / (PATHS[0] * paths[c]);
        [sigma_s_prime[c] * paths[c], sigma_a[c] * paths[c], boundary[c], factor]
    });
    let found = looked_up(KEPT.get_or_init(Mutex::default), shares, in_paths);
    [0, 1, 2].map(|c| found[c] * paths[c])
}

/// Fits that have been computed.
type Kept = Mutex<HashMap<Key, f64>>;

/// The kept value of each channel; values that are not kept are computed, and kept.
fn looked_up(kept: &Kept, shares: [[f64; 4]; 3], compute: impl Fn([f64; 4]) -> f64 + Sync) -> [f64; 3] {
    let lock = || kept.lock().unwrap_or_else(PoisonError::into_inner);
    let keys = shares.map(|share| share.map(f64::to_bits));
    let known = {
        let kept = lock();
        keys.map(|key| kept.get(&key).copied())
    };
    if let [Some(r), Some(g), Some(b)] = known {
        return [r, g, b];
    }
    let mut found = [0.0; 3];
    found.par_iter_mut().zip(shares).zip(known).for_each(|((found, share), known)| {
        *found = known.unwrap_or_else(|| compute(share));
    });
    let mut kept = lock();
    if kept.len() > MOST {
        kept.clear();
    }
    kept.extend(keys.into_iter().zip(found));
    found
}

/// The fit in mean free paths; 0 where nothing is scattered.
fn in_paths([scattering, absorption, boundary, factor]: [f64; 4]) -> f64 {
    let dipole = Dipole::new(scattering, absorption, boundary);
    // Below this, so little light comes back that its ratios would lose their digits.
    if dipole.total() < 1e-200 {
        return if scattering > 0.0 { spread(&dipole) } else { 0.0 };
    }
    let balls = PATHS.map(|paths| curve(&dipole, paths * factor / (scattering + absorption)));
    fit(&balls, spread(&dipole), false).sigma_0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_spread_is_the_profiles_own() {
        let dipole = Dipole::new(2.19, 0.0021, 3.96);
        // Half the mean square distance between entry and exit.
        let (mut sum, mut whole) = (0.0, 0.0);
        for k in 0..400_000 {
            let r = 2e-3 * (f64::from(k) + 0.5);
            let ring = 2.0 * PI * r * dipole.reflectance(r) * 2e-3;
            (sum, whole) = (sum + 0.5 * r * r * ring, whole + ring);
        }
        let expected = (sum / whole).sqrt();
        assert!((spread(&dipole) / expected - 1.0).abs() < 1e-4, "{} {expected}", spread(&dipole));
        let clear = Dipole::new(2.0, 0.0, 3.0);
        assert_eq!(spread(&clear), 10.0 * clear.z_real);
    }

    #[test]
    fn every_material_has_one() {
        // From nearly clear to nearly black, boundaries of eta 1 to 5, and channels that differ by a million.
        for (k, sigma_a) in [0.0, 1e-9, 1e-3, 0.1, 1.0, 30.0, 1e6].into_iter().enumerate() {
            let boundary = [1.0, 3.0, 60.0];
            let one = fitted([1.0; 3], [sigma_a; 3], boundary);
            assert!(one.iter().all(|x| (1e-4..20.0).contains(&(x * (1.0 + sigma_a)))), "{k}: {one:?}");
            // Lengths scale with the coefficients.
            let fine = fitted([1e6; 3], [sigma_a * 1e6; 3], boundary);
            (0..3).for_each(|c| assert!((fine[c] * 1e6 / one[c] - 1.0).abs() < 1e-6, "{fine:?} {one:?}"));
        }
        assert_eq!(fitted([0.0; 3], [2.0; 3], [3.0; 3]), [0.0; 3]);
        let alone = fitted([1.0; 3], [0.01; 3], [3.0; 3])[0];
        let apart = fitted([1e-6, 1.0, 1.0], [1e-8, 0.01, 0.01], [3.0; 3]);
        assert!(
            (0.5..2.0).contains(&(apart[1] / alone)) && (0.5..2.0).contains(&(apart[0] * 1e-6 / alone)),
            "{apart:?}"
        );
    }

    #[test]
    fn a_fit_is_computed_once() {
        let (kept, count) = (Mutex::default(), std::sync::atomic::AtomicUsize::new(0));
        let sum = |share: [f64; 4]| {
            count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            share.iter().sum()
        };
        let shares = [[0.9, 0.1, 3.0, 1.0], [0.8, 0.2, 3.0, 1.0], [0.7, 0.3, 3.0, 1.0]];
        let first = looked_up(&kept, shares, sum);
        assert_eq!((looked_up(&kept, shares, sum), count.load(std::sync::atomic::Ordering::Relaxed)), (first, 3));
        // One channel differs.
        looked_up(&kept, [shares[0], shares[1], [0.6, 0.4, 3.0, 1.0]], sum);
        assert_eq!(count.load(std::sync::atomic::Ordering::Relaxed), 4);
    }
}
