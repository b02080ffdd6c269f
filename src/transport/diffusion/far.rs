//! A cluster's layers seen from afar, in one channel:
//! `w g - U.grad g + Y : grad grad g - (Q, U) : grad grad grad g / 2`,
//! with the kernel `g(s) = e^(-k s) / (4 pi s)`, by Taylor's series about the cluster's middle.
//!
//! w is the sum of b / z_b over the cluster's triangles (b: value times area), U that of b (n + e / z_b), with e the
//! vector from the middle, Y that of b (e n + n e + e e / z_b) / 2, and Q the mean of e e over the area: the third
//! order takes e e to be independent of b and n.

use glam::{DMat3, DVec3};

use crate::layout::{Buffers, SecondMoments};
use crate::state::wide;

/// A symmetric matrix from its diagonal and from yz, zx, xy.
fn symmetric(diagonal: DVec3, [yz, zx, xy]: [f64; 3]) -> DMat3 {
    DMat3::from_cols(DVec3::new(diagonal.x, xy, zx), DVec3::new(xy, diagonal.y, yz), DVec3::new(zx, yz, diagonal.z))
}

/// The product of two vectors as a matrix.
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// The second moment of a cluster's area about its middle, per area.
pub(super) fn area_moment(s: &SecondMoments) -> DMat3 {
    symmetric(wide(s.diagonal), s.mixed.map(f64::from))
}

/// The derivatives of g: `g1 = g'/s`, `g2 = g1'/s`, `g3 = g2'/s`.
struct Jet {
    g: f64,
    first: f64,
    second: f64,
    third: f64,
}

fn jet(k: f64, s: f64) -> Jet {
    let (a, s2) = (k * s, s * s);
    let g = (-a).exp() / (4.0 * std::f64::consts::PI * s);
    Jet {
        g,
        first: -(1.0 + a) * g / s2,
        second: (3.0 + 3.0 * a + a * a) * g / (s2 * s2),
        third: -(15.0 + 15.0 * a + 6.0 * a * a + a * a * a) * g / (s2 * s2 * s2),
    }
}

impl Jet {
    /// The second derivatives at `d`, applied to a vector.
    fn second_of(&self, d: DVec3, v: DVec3) -> DVec3 {
        self.first * v + self.second * d.dot(v) * d
    }

    /// The third derivatives at `d`, contracted with a symmetric matrix.
    fn third_of(&self, d: DVec3, m: &DMat3) -> DVec3 {
        self.second * (2.0 * (*m * d) + trace(m) * d) + self.third * d.dot(*m * d) * d
    }
}

/// The kernel at a distance.
pub(super) fn kernel(k: f64, s: f64) -> f64 {
    jet(k, s).g
}

/// The kernel's derivative by the distance, divided by the distance.
pub(super) fn slope(k: f64, s: f64) -> f64 {
    jet(k, s).first
}

/// A cluster's layers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layers {
    /// The middle.
    pub center: DVec3,
    /// w.
    pub charge: f64,
    /// U.
    pub first: DVec3,
    /// Y.
    pub second: DMat3,
}

/// A cluster's potential about a block's centre: value, gradient, second derivatives.
#[derive(Clone, Copy)]
pub(super) struct Quadratic {
    pub value: f64,
    pub gradient: DVec3,
    pub second: DMat3,
}

impl Quadratic {
    pub(super) const ZERO: Self = Self { value: 0.0, gradient: DVec3::ZERO, second: DMat3::ZERO };
}

impl Layers {
    pub(super) const ZERO: Self = Self { center: DVec3::ZERO, charge: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    /// The layers of a node in one channel.
    pub(super) fn of(data: &Buffers, node: usize, c: usize) -> Self {
        let (place, first) = (&data.layer_places[node], &data.layer_firsts[node]);
        let (squares, products) = (&data.layer_squares[node], &data.layer_products[node]);
        let at = |x: &[f32; 3], y: &[f32; 3], z: &[f32; 3]| DVec3::new(x[c].into(), y[c].into(), z[c].into());
        let mixed = at(&products.x, &products.y, &products.z).to_array();
        Self {
            center: at(&place.x, &place.y, &place.z),
            charge: place.charge[c].into(),
            first: at(&first.x, &first.y, &first.z),
            second: symmetric(at(&squares.x, &squares.y, &squares.z), mixed),
        }
    }

    /// The same layers about another middle.
    pub(super) fn about(&self, center: DVec3) -> Self {
        let t = self.center - center;
        let across = outer(t, self.first);
        Self {
            center,
            charge: self.charge,
            first: self.first + self.charge * t,
            second: self.second + 0.5 * (across + across.transpose() + self.charge * outer(t, t)),
        }
    }

    /// Their potential at a place.
    pub(super) fn at(&self, k: f64, area: &DMat3, x: DVec3) -> f64 {
        let d = x - self.center;
        let jet = jet(k, d.length());
        let second = jet.first * trace(&self.second) + jet.second * d.dot(self.second * d);
        let third = self.first.dot(jet.third_of(d, area));
        self.charge * jet.g - jet.first * self.first.dot(d) + second - 0.5 * third
    }

    /// Their potential about a place.
    pub(super) fn expanded(&self, k: f64, area: &DMat3, x: DVec3) -> Quadratic {
        let d = x - self.center;
        let jet = jet(k, d.length());
        let gradient = self.charge * jet.first * d - jet.second_of(d, self.first) + jet.third_of(d, &self.second);
        let u = self.first;
        let across = outer(u, d);
        let of_first = jet.second * (across + across.transpose() + u.dot(d) * DMat3::IDENTITY)
            + jet.third * u.dot(d) * outer(d, d);
        let of_charge = jet.first * DMat3::IDENTITY + jet.second * outer(d, d);
        Quadratic { value: self.at(k, area, x), gradient, second: self.charge * of_charge - of_first }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patches of a bent surface: places, normals, values.
    fn patches() -> Vec<(DVec3, DVec3, f64)> {
        let patch = |i: usize| {
            let (u, v) = (0.02 * (i % 10) as f64 - 0.09, 0.02 * (i / 10) as f64 - 0.09);
            let normal = DVec3::new(0.8 * u, -0.5 * v, 1.0).normalize();
            (DVec3::new(u, v, -0.4 * u * u + 0.25 * v * v), normal, 1e-3 * (1.0 + 2.0 * u - v + 9.0 * u * v))
        };
        (0..100).map(patch).collect()
    }

    #[test]
    fn the_series_converges_to_the_sum_over_patches() {
        let (z_b, patches) = (0.3, patches());
        let center = patches.iter().map(|p| p.0).sum::<DVec3>() / 100.0;
        let area = patches.iter().map(|p| outer(p.0 - center, p.0 - center)).fold(DMat3::ZERO, |a, b| a + b) * 0.01;
        let mut layers = Layers { center, ..Layers::ZERO };
        for &(place, normal, b) in &patches {
            let one = Layers { center: place, charge: b / z_b, first: b * normal, second: DMat3::ZERO }.about(center);
            layers.charge += one.charge;
            layers.first += one.first;
            layers.second += one.second;
        }
        for k in [0.0, 1.0] {
            let exact = |x: DVec3| -> f64 {
                let patch = |&(place, normal, b): &(DVec3, DVec3, f64)| {
                    let d = x - place;
                    b * (kernel(k, d.length()) / z_b - slope(k, d.length()) * d.dot(normal))
                };
                patches.iter().map(patch).sum()
            };
            for way in [DVec3::new(0.6, 0.3, 0.74), DVec3::X, DVec3::new(-0.1, 0.9, -0.4)] {
                let off = |distance: f64| {
                    let x = center + distance * way;
                    (layers.at(k, &area, x) - exact(x)).abs() / (kernel(k, distance) * 0.1 / z_b)
                };
                let (near, far) = (off(0.5), off(1.0));
                assert!(near < 1e-2 && far < 0.2 * near + 1e-9, "{k} {way}: {near:.1e} {far:.1e}");

                // About a block's centre, the third order is lost.
                let (x, step) = (center + 0.7 * way, DVec3::new(0.01, -0.02, 0.015));
                let e = layers.expanded(k, &area, x);
                let value = |by: f64| {
                    let d = by * step;
                    let series = e.value + e.gradient.dot(d) + 0.5 * d.dot(e.second * d);
                    (series - exact(x + d) - (e.value - exact(x))).abs() / (kernel(k, 0.7) * 0.1 / z_b)
                };
                assert!(value(1.0) < 1.5e-3 && value(0.25) < 4e-4, "{k} {way}: {:.1e} {:.1e}", value(1.0), value(0.25));
            }
        }
    }
}
