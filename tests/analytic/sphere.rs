//! A closed sphere under constant irradiance: form factors summed over a mesh against the smooth surface.

use glam::DVec3;
use milkglass::internals::dipole::form_factor::{Distance, edge::edge_form, gauss::SIX};
use milkglass::internals::dipole::profile::Dipole;
use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::quadrature::on_line;

/// Vertices and triangles of an icosahedron, each face subdivided into four `levels` times.
pub fn icosphere(levels: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let g = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut positions = Vec::new();
    for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        positions.push(DVec3::new(a, b, 0.0).normalize());
    }
    for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        positions.push(DVec3::new(0.0, a, b).normalize());
    }
    for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        positions.push(DVec3::new(b, 0.0, a).normalize());
    }
    // The faces are the triples of vertices one edge length apart, oriented outward.
    let near = |a: usize, b: usize| positions[a].distance(positions[b]) < 1.1;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let normal = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
                    let out = normal.dot(positions[a]) > 0.0;
                    triangles.push(if out { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q): (u32, u32)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let sum = positions[p as usize] + positions[q as usize];
                    positions.push(sum.normalize());
                    positions.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (positions, triangles)
}

#[test]
fn constant_irradiance_on_a_sphere() {
    // A unit sphere in three media, from translucent to nearly opaque.
    for scale in [1.0, 10.0, 50.0] {
        let dipole = Dipole::new(2.62 * scale, 0.0041 * scale, 3.96);
        // The part of a unit sphere within chord length d of a point has area pi d^2.
        let smooth = on_line(0.0, 2.0, 0.5 * dipole.z_real, |d| 2.0 * PI * d * dipole.reflectance(d));
        let errors = [2, 3, 4].map(|levels| {
            let (positions, triangles) = icosphere(levels);
            // A vertex of the icosahedron stays on the sphere at every level.
            let sum: f64 = triangles
                .iter()
                .map(|t| {
                    let corners = t.map(|i| positions[i as usize]);
                    edge_form(&corners, *t, positions[0], &dipole, Distance::Radial, &SIX)
                })
                .sum();
            (sum / smooth - 1.0).abs()
        });
        println!("sphere, scale {scale}: relative errors {errors:?}");
        // Second order: each refinement divides the error by about four.
        assert!(errors[2] < 2e-3 && errors[2] < errors[1] / 3.0 && errors[1] < errors[0] / 3.0);
    }
}
