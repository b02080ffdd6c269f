//! Whether two runs of a scene give the same result, so that their times may be compared.

use crate::error::{Error, Result};

/// How far two results are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Agreement {
    /// Bit for bit the same.
    Same,
    /// Root of the sum of squared differences over that of the squares of the first, within what was allowed.
    Within(f64),
}

impl std::fmt::Display for Agreement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Same => write!(f, "bit for bit the same result"),
            Self::Within(l2) => write!(f, "results within {l2:.1e} (L2) of each other"),
        }
    }
}

/// Compares results, floats as bytes; fails if they are further apart than `tolerance`, of different sizes, or not
/// numbers.
pub fn agreement(names: [&str; 2], results: [&[u8]; 2], tolerance: f64) -> Result<Agreement> {
    let [first, other] = results;
    if first == other {
        return Ok(Agreement::Same);
    }
    let differ = |how: String| {
        let [one, two] = names;
        Error::Check(format!("{one} and {two} compute different results, so that nothing was timed: {how}"))
    };
    if first.len() != other.len() {
        return Err(differ(format!("{} and {} bytes", first.len(), other.len())));
    }
    let floats = |bytes: &[u8]| -> Vec<f64> {
        bytes.chunks_exact(4).map(|four| f32::from_ne_bytes([four[0], four[1], four[2], four[3]]).into()).collect()
    };
    let (one, two) = (floats(first), floats(other));
    let apart: f64 = one.iter().zip(&two).map(|(a, b)| (a - b) * (a - b)).sum();
    let l2 = (apart / one.iter().map(|a| a * a).sum::<f64>()).sqrt();
    if l2 <= tolerance {
        return Ok(Agreement::Within(l2));
    }
    Err(differ(format!("L2 {l2:.1e}, allowed {tolerance:.1e}, the scene's transport.tolerance")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_not_timed() {
        let bytes = |values: &[f32]| values.iter().flat_map(|value| value.to_ne_bytes()).collect::<Vec<u8>>();
        let (one, near) = (bytes(&[1.0, 2.0]), bytes(&[1.0, 2.001]));
        let of = |other: &[u8], tolerance| agreement(["a", "b"], [&one, other], tolerance);
        assert_eq!(of(&one, 0.0).unwrap(), Agreement::Same);
        assert!(matches!(of(&near, 1e-3).unwrap(), Agreement::Within(l2) if (l2 - 4.5e-4).abs() < 1e-5));
        for (other, word) in [(near, "L2 4.5e-4"), (bytes(&[1.0]), "8 and 4 bytes"), (bytes(&[1.0, f32::NAN]), "NaN")] {
            let Err(Error::Check(text)) = of(&other, 1e-4) else { panic!("{word}") };
            assert!(text.contains(word) && text.contains("a and b"), "{text}");
        }
    }
}
