//! The form factor as Mertens et al. 2003 evaluate it: equation 10 per edge, its second integral by the first term of
//! equation 17 on segments that are halved until condition 19 holds. For comparison only: it suffers from
//! cancellation and is expensive.
//!
//! Our reading: edges through the foot point contribute nothing, R has the sign that the rule at equation 18 gives,
//! and the angles of the first integral add up to the angle at the foot, also on a corner or an edge.

use glam::DVec3;

use crate::dipole::form_factor::Distance;
use crate::dipole::form_factor::footprint::{Edge, Footprint};
use crate::dipole::profile::Dipole;

/// Maximum depth of halving; a foot point on an edge would never stop.
const DEEPEST: u32 = 60;

/// A form factor, and the number of segments (exponentials) for both sources together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segmented {
    /// The value, no unit.
    pub value: f64,
    /// Number of segments evaluated.
    pub segments: usize,
}

/// The form factor of a triangle seen from `x_o`. If `stiff`, segments also satisfy L < 2/(5 sigma), a condition that
/// the paper finds dispensable.
#[must_use]
pub fn form_factor(triangle: &[DVec3; 3], x_o: DVec3, dipole: &Dipole, stiff: bool) -> Segmented {
    let mut sum = Segmented::default();
    let Some(footprint) = Footprint::new(triangle, [0, 1, 2], x_o) else {
        return sum;
    };
    let longest = if stiff && dipole.sigma > 0.0 { 0.4 / dipole.sigma } else { f64::INFINITY };
    let heights = Distance::Radial.heights(footprint.delta, dipole);
    for (z, h) in dipole.depths().into_iter().zip(heights) {
        let around = z / h * (-dipole.sigma * h).exp();
        for edge in footprint.edges.iter().filter(|edge| edge.offset != 0.0) {
            let angle = |t: f64| (t / edge.offset).atan();
            let line = Line { edge, sigma: dipole.sigma, height: h, longest };
            let second = line.integral(edge.start, edge.end, 0, &mut sum.segments);
            sum.value += edge.sense * (around * (angle(edge.end) - angle(edge.start)) - z * second);
        }
    }
    sum.value *= dipole.strength;
    sum
}

/// One edge under one source.
struct Line<'a> {
    edge: &'a Edge,
    sigma: f64,
    height: f64,
    longest: f64,
}

impl Line<'_> {
    /// Equation 17 over [t1, t2], without the factor z.
    fn integral(&self, t1: f64, t2: f64, depth: u32, segments: &mut usize) -> f64 {
        let (length, t) = (t2 - t1, 0.5 * (t1 + t2));
        let r = self.edge.offset.hypot(t);
        if depth < DEEPEST && (length >= 0.4 * r || length >= self.longest) {
            return self.integral(t1, t, depth + 1, segments) + self.integral(t, t2, depth + 1, segments);
        }
        *segments += 1;
        let s = r.hypot(self.height);
        self.edge.offset * (-self.sigma * s).exp() / (r * r * s) * length
    }
}
