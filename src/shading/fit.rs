//! Principal curvatures by a cubic fit (Goldfeather and Interrante 2004), on the host: an independent estimate to
//! compare stage `curvature` with.
//!
//! In the frame of a vertex and its normal the surface is
//! z = A x^2 / 2 + B x y + C y^2 / 2 + D x^3 + E x^2 y + F x y^2 + G y^3.
//! Each neighbour's position and the two slopes of its normal give three equations for the seven unknowns, solved by
//! least squares. The curvatures are the eigenvalues of the second derivatives; outward is positive.

use glam::DVec3;

use crate::layout::Buffers;
use crate::state::wide;

/// Number of unknowns.
const TERMS: usize = 7;

/// Accumulated normal equations: matrix, and right-hand side as the last column.
#[derive(Default)]
struct Equations {
    rows: [[f64; TERMS + 1]; TERMS],
}

impl Equations {
    fn add(&mut self, row: [f64; TERMS], value: f64) {
        for i in 0..TERMS {
            for j in 0..TERMS {
                self.rows[i][j] += row[i] * row[j];
            }
            self.rows[i][TERMS] += row[i] * value;
        }
    }

    /// The unknowns, by Gauss-Jordan elimination; none where the system is singular.
    fn solve(mut self) -> Option<[f64; TERMS]> {
        let largest = self.rows.iter().flat_map(|row| &row[..TERMS]).fold(0.0, |m: f64, x| m.max(x.abs()));
        for i in 0..TERMS {
            let pivot = (i..TERMS).max_by(|&a, &b| self.rows[a][i].abs().total_cmp(&self.rows[b][i].abs()))?;
            self.rows.swap(i, pivot);
            // Singular, or not finite.
            let singular = self.rows[i][i].abs() <= 1e-10 * largest || !self.rows[i][i].is_finite();
            if singular {
                return None;
            }
            let pivot_row = self.rows[i];
            for (_, row) in self.rows.iter_mut().enumerate().filter(|(k, _)| *k != i) {
                let factor = row[i] / pivot_row[i];
                row.iter_mut().zip(pivot_row).for_each(|(x, y)| *x -= factor * y);
            }
        }
        Some(std::array::from_fn(|i| self.rows[i][TERMS] / self.rows[i][i]))
    }
}

/// Principal curvatures, the larger first, 1/length, from the neighbours' offsets and unit normals; none where there
/// are too few, or where they do not determine a surface over the vertex's tangent plane.
#[must_use]
pub fn principal(normal: DVec3, neighbours: &[(DVec3, DVec3)]) -> Option<[f64; 2]> {
    let length = neighbours.iter().map(|(offset, _)| offset.length()).sum::<f64>() / neighbours.len() as f64;
    let frame = [normal.any_orthonormal_vector(), normal.cross(normal.any_orthonormal_vector()), normal];
    let inside = |v: DVec3| frame.map(|axis| axis.dot(v));
    let mut equations = Equations::default();
    for &(offset, tilted) in neighbours {
        let ([x, y, z], [a, b, c]) = (inside(offset / length), inside(tilted));
        if c <= 0.1 {
            continue;
        }
        equations.add([0.5 * x * x, x * y, 0.5 * y * y, x * x * x, x * x * y, x * y * y, y * y * y], z);
        equations.add([x, y, 0.0, 3.0 * x * x, 2.0 * x * y, y * y, 0.0], -a / c);
        equations.add([0.0, x, y, 0.0, x * x, 2.0 * x * y, 3.0 * y * y], -b / c);
    }
    let [a, b, c, ..] = equations.solve()?.map(|x| -x / length);
    let (mean, half) = (0.5 * (a + c), (0.25 * (a - c) * (a - c) + b * b).sqrt());
    Some([mean + half, mean - half])
}

/// Principal curvatures at a vertex, the larger first, from the other corners of its triangles. `data` holds one object
/// only, after stage `curvature`. None where a neighbour lies at an open edge: its normal averages one side only.
#[must_use]
pub fn at(data: &Buffers, vertex: usize) -> Option<[f64; 2]> {
    let first = data.object_params[0].first_vertex;
    let faces = &data.corners[data.corner_starts[vertex] as usize..data.corner_starts[vertex + 1] as usize];
    let own = first + vertex as u32;
    let mut others: Vec<u32> = faces.iter().flat_map(|&f| data.triangles[f as usize]).filter(|&v| v != own).collect();
    others.sort_unstable();
    others.dedup();
    if others.iter().any(|&v| data.curvature[(v - first) as usize].area == 0.0) {
        return None;
    }
    let place = wide(data.positions[own as usize]);
    let neighbour = |&v: &u32| (wide(data.positions[v as usize]) - place, wide(data.normals[(v - first) as usize]));
    let neighbours: Vec<_> = others.iter().map(neighbour).collect();
    principal(wide(data.normals[vertex]).try_normalize()?, &neighbours)
}

#[cfg(test)]
mod tests {
    use crate::shading::fit::*;

    #[test]
    fn a_cubic_surface_has_its_own_curvatures() {
        // z = -(2 x^2 + 6 x y - y^2) / 2 + x^3 / 4 - x y^2, turned.
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
        let neighbour = |k: u32| {
            let (x, y) = (0.1 * (1.9 * f64::from(k)).cos(), 0.12 * (1.3 * f64::from(k) + 0.3).sin());
            let z = -(2.0 * x * x + 6.0 * x * y - y * y) / 2.0 + x * x * x / 4.0 - x * y * y;
            let slopes = [-(2.0 * x + 3.0 * y) + 0.75 * x * x - y * y, -(3.0 * x - y) - 2.0 * x * y];
            (turn * DVec3::new(x, y, z), turn * DVec3::new(-slopes[0], -slopes[1], 1.0).normalize())
        };
        let neighbours: Vec<_> = (0..6).map(neighbour).collect();
        let [k1, k2] = principal(turn * DVec3::Z, &neighbours).expect("a fit");
        let half = (1.5f64 * 1.5 + 9.0).sqrt();
        assert!((k1 - 0.5 - half).abs() < 1e-9 && (k2 - 0.5 + half).abs() < 1e-9, "{k1} {k2}");
        assert_eq!(principal(DVec3::Z, &neighbours[..2]), None);
        assert_eq!(principal(DVec3::Z, &[]), None);
    }
}
