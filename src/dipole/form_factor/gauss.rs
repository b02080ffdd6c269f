//! Gauss-Legendre quadrature on [-1, 1]: nodes as roots of Legendre polynomials.

use std::f64::consts::PI;

/// One node of a quadrature rule on [-1, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Where the integrand is evaluated, in (-1, 1).
    pub x: f64,
    /// Its weight, positive; the weights of a rule sum to 2.
    pub weight: f64,
}

/// The rule with 3 nodes, exact to degree 5: for the borders of clusters, whose edges are short for their distance.
pub const THREE: [Node; 3] = [
    Node { x: -0.774_596_669_241_483_4, weight: 5.0 / 9.0 },
    Node { x: 0.0, weight: 8.0 / 9.0 },
    Node { x: 0.774_596_669_241_483_4, weight: 5.0 / 9.0 },
];

/// The rule with 6 nodes, exact to degree 11: the one that scheme `links` and brute force use.
pub const SIX: [Node; 6] = [
    Node { x: -0.932_469_514_203_152, weight: 0.171_324_492_379_170_36 },
    Node { x: -0.661_209_386_466_264_5, weight: 0.360_761_573_048_138_6 },
    Node { x: -0.238_619_186_083_196_9, weight: 0.467_913_934_572_691 },
    Node { x: 0.238_619_186_083_196_9, weight: 0.467_913_934_572_691 },
    Node { x: 0.661_209_386_466_264_5, weight: 0.360_761_573_048_138_6 },
    Node { x: 0.932_469_514_203_152, weight: 0.171_324_492_379_170_36 },
];

/// The rule with `count` nodes in rising order, exact to degree `2 count - 1`; empty for 0.
///
/// Newton iteration on the Legendre polynomial from the asymptotic guess of its roots. The rule is
/// symmetric to the last bit.
#[must_use]
pub fn legendre(count: usize) -> Vec<Node> {
    let mut nodes = vec![Node { x: 0.0, weight: 2.0 }; count];
    for i in 0..count.div_ceil(2) {
        // The middle root of an odd rule is 0 exactly.
        let middle = 2 * i + 1 == count;
        let guess = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut x = if middle { 0.0 } else { guess };
        for _ in 0..8 {
            let (value, slope) = polynomial(count, x);
            x -= if middle { 0.0 } else { value / slope };
        }
        let (_, slope) = polynomial(count, x);
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        nodes[i] = Node { x: -x, weight };
        nodes[count - 1 - i] = Node { x, weight };
    }
    nodes
}

/// The Legendre polynomial of this degree (at least 1) and its derivative at `x` in (-1, 1).
fn polynomial(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=degree {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, degree as f64 * (x * value - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_what_newton_finds() {
        for (table, found) in SIX.iter().zip(legendre(6)) {
            assert!((table.x - found.x).abs() < 4e-16);
            assert!((table.weight - found.weight).abs() < 4e-16);
        }
    }

    #[test]
    fn exact_for_the_promised_degree() {
        for count in [1, 2, 3, 6, 7, 24] {
            let rule = legendre(count);
            for power in (0..2 * count).step_by(2) {
                let sum: f64 = rule.iter().map(|n| n.weight * n.x.powi(power as i32)).sum();
                assert!((sum - 2.0 / (power as f64 + 1.0)).abs() < 1e-14, "{count} {power}");
            }
        }
        assert!(legendre(0).is_empty());
    }
}
