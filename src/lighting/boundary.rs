//! A smooth boundary as diffusion inside sees it: the extrapolation factor A and the mean cosine of light that enters.

use super::fresnel::transmittance;

/// The number of midpoints of each integral; the integrands are smooth but for the critical angle.
const POINTS: usize = 4000;

/// The mean of a function over (0, 1).
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    (0..POINTS).map(|k| f((k as f64 + 0.5) / POINTS as f64)).sum::<f64>() / POINTS as f64
}

/// A = (1 + 3 C2) / (1 - 2 C1), with C1 and C2 the integrals of the reflectance from within times mu and mu squared;
/// light vanishes 2 A D beyond the surface. 1 without a boundary.
///
/// `eta`: index inside over outside, positive.
#[must_use]
pub fn extrapolation(eta: f64) -> f64 {
    let within = |mu: f64| 1.0 - transmittance(1.0 / eta, mu);
    let [first, second] = [1, 2].map(|power| mean(|mu| within(mu) * mu.powi(power)));
    (1.0 + 3.0 * second) / (1.0 - 2.0 * first).max(1e-9)
}

/// The mean cosine inside of light that enters from all around.
#[must_use]
pub fn mean_inner_cosine(eta: f64) -> f64 {
    let entering = |mu: f64| transmittance(eta, mu) * mu;
    let inside = |mu: f64| (1.0 - (1.0 - mu * mu) / (eta * eta)).max(0.0).sqrt();
    mean(|mu| entering(mu) * inside(mu)) / mean(entering).max(1e-30)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // By adaptive quadrature in many digits.
        assert!((extrapolation(1.5) - 3.627_93).abs() < 2e-4, "{}", extrapolation(1.5));
        assert!((mean_inner_cosine(1.5) - 0.884_54).abs() < 2e-5, "{}", mean_inner_cosine(1.5));
        // Without a boundary all light passes, and the mean cosine of light from all around is 2/3.
        assert_eq!(extrapolation(1.0), 1.0);
        assert!((mean_inner_cosine(1.0) - 2.0 / 3.0).abs() < 1e-6);
        // The denser the medium, the more light is held back; some is where the medium is thinner than air, too.
        let rising: Vec<f64> = [1.0, 1.2, 1.5, 2.0, 2.5].map(extrapolation).into();
        assert!(rising.windows(2).all(|pair| pair[0] < pair[1]) && extrapolation(0.8) > 1.0, "{rising:?}");
    }
}
