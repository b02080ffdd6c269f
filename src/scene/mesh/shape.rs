//! Built-in shapes: closed except for the plane, oriented outwards, and as fine as their `detail` says.

use super::{Mesh, bust, candle, fish, gecko, lotus, number, relief, sweep, uv};
use glam::DVec3;
use serde::Deserialize;
use std::collections::HashMap;

/// A shape that needs no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A ball of radius 1 with triangles of nearly the same size; detail: subdivisions.
    Sphere,
    /// A box of 1 x 1 x 0.2, thin along z; detail: cells along a long side.
    Slab,
    /// An open bowl of petals, about 2 across, opening towards +y; detail: cells around the circle.
    Lotus,
    /// An open square of 1 x 1 in the xz-plane, facing +y; detail: cells along a side.
    Plane,
    /// A cube of 1 with rounded edges; detail: cells along a side.
    Cube,
    /// A torus in the xy-plane, 2.8 across, its tube 0.8 thick; detail: cells along it.
    Torus,
    /// A slab of 1 x 0.2 x 1 with rounded edges and a smooth bump of 0.2 on its top; detail: cells along a side.
    Bump,
    /// A candle with a hollow in its top, 1 high, 0.7 across; detail: cells around the circle.
    Candle,
    /// A head on shoulders and a plinth, 1.8 high, looking along +z; detail: grid cells from top to bottom.
    Bust,
    /// A fish, 1 long along x, seen from its side along z; detail: 1 has 2788 triangles.
    Fish,
    /// A gecko with a bumpy skin, 1 long along x, its back at +y; detail: 1 has 10,944 triangles.
    Gecko,
}

impl Shape {
    /// Builds the shape; `detail` is clamped to [`Shape::details`].
    pub fn build(self, detail: u32) -> Mesh {
        let detail = detail.clamp(*self.details().start(), *self.details().end());
        match self {
            Self::Sphere => sphere(detail),
            Self::Slab => slab(detail),
            Self::Lotus => lotus::lotus(detail),
            Self::Plane => relief::plane(detail),
            Self::Cube => relief::cube(detail),
            Self::Torus => sweep::torus(detail, TUBE),
            Self::Bump => relief::bump(detail),
            Self::Candle => candle::candle(detail),
            Self::Bust => bust::bust(detail),
            Self::Fish => fish::fish(detail),
            Self::Gecko => gecko::gecko(detail),
        }
    }

    /// The same with texture coordinates.
    pub fn build_textured(self, detail: u32) -> Mesh {
        let mesh = self.build(detail);
        Mesh { uvs: Some(uv::of_shape(self, &mesh)), ..mesh }
    }
}

/// Minor radius of the torus.
const TUBE: f64 = 0.4;

/// A subdivided icosahedron, its vertices projected onto the unit sphere.
fn sphere(subdivisions: u32) -> Mesh {
    let g = f64::midpoint(1.0, 5f64.sqrt());
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        for corner in [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)] {
            positions.push(corner.normalize());
        }
    }

    // The faces of the icosahedron: three corners each 2 / |corner| apart, oriented outwards.
    let edge = 2.0 / (1.0 + g * g).sqrt() + 1e-9;
    let near = |a: usize, b: usize| positions[a].distance(positions[b]) < edge;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = positions[a].dot(positions[b].cross(positions[c])) > 0.0;
                    let corners = if outward { [a, b, c] } else { [a, c, b] };
                    triangles.push(corners.map(number));
                }
            }
        }
    }

    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for &[a, b, c] in &triangles {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    number(positions.len() - 1)
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    Mesh::made(positions, triangles)
}

/// A box of 1 x 1 x 0.2 with cells that are nearly cubes.
fn slab(cells: u32) -> Mesh {
    let counts = [cells, cells, (cells / 5).max(1)];
    let extent = DVec3::new(1.0, 1.0, 0.2);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut numbers = HashMap::new();
    let mut vertex = |place: [u32; 3]| {
        *numbers.entry(place).or_insert_with(|| {
            let part = |axis: usize| f64::from(place[axis]) / f64::from(counts[axis]) - 0.5;
            positions.push(DVec3::new(part(0), part(1), part(2)) * extent);
            number(positions.len() - 1)
        })
    };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, counts[axis]] {
            for i in 0..counts[u] {
                for j in 0..counts[v] {
                    let mut corner = |di: u32, dj: u32| {
                        let mut place = [side; 3];
                        (place[u], place[v]) = (i + di, j + dj);
                        vertex(place)
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    if side > 0 {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        triangles.extend([[a, c, b], [a, d, c]]);
                    }
                }
            }
        }
    }
    Mesh::made(positions, triangles)
}

#[cfg(test)]
mod tests {
    use super::super::{clean, edges::Edges, import::Soup, orient};
    use super::*;

    /// A shape passes the import unchanged.
    fn check(shape: Shape, detail: u32) -> Mesh {
        let mesh = shape.build(detail);
        let edges = Edges::of(&mesh.triangles);
        assert_eq!((edges.open, edges.crowded), (0, 0), "{shape:?} {detail}");
        let soup = Soup {
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            input_face: mesh.input_face.clone(),
            ..Soup::default()
        };
        let mut report = Vec::new();
        let (mut again, _) = clean::clean(soup, &mut report).expect("faces with an area");
        orient::orient(&mut again, &mut report).expect("sides");
        assert_eq!(report, Vec::<String>::new(), "{shape:?} {detail}");
        assert_eq!(again.triangles.len(), mesh.triangles.len());
        assert!(mesh.volume() > 0.0);
        mesh
    }

    #[test]
    fn spheres_are_closed_and_approach_the_ball() {
        for detail in 0..=5 {
            let mesh = check(Shape::Sphere, detail);
            assert_eq!(mesh.triangles.len(), 20 << (2 * detail));
            assert!(mesh.positions.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
        }
        let volume = Shape::Sphere.build(5).volume();
        assert!((volume / (std::f64::consts::PI * 4.0 / 3.0) - 1.0).abs() < 2e-3);
    }

    #[test]
    fn slabs_are_closed_boxes() {
        for detail in [1, 2, 5, 32, 33] {
            let mesh = check(Shape::Slab, detail);
            assert!((mesh.volume() - 0.2).abs() < 1e-12);
            let (low, high) = mesh.bounds();
            assert!((high - low - DVec3::new(1.0, 1.0, 0.2)).length() < 1e-12);
        }
    }

    #[test]
    fn lotuses_are_closed_bowls() {
        for detail in [16, 17, 50, 256] {
            let mesh = check(Shape::Lotus, detail);
            let (low, high) = mesh.bounds();
            let extent = high - low;
            assert!(extent.x > 1.6 && extent.x < 2.6 && extent.y < extent.x, "{extent}");
        }
    }

    #[test]
    fn bumps_are_closed_slabs_with_a_bump() {
        for detail in [1, 8, 33, 128] {
            let (low, high) = check(Shape::Bump, detail).bounds();
            let extent = high - low;
            assert!((extent.x - 1.0).abs() < 1e-9 && (extent.z - 1.0).abs() < 1e-9, "{extent}");
            assert!(extent.y > 0.2 - 1e-9 && extent.y < 0.4 + 1e-9, "{extent}");
        }
    }

    #[test]
    fn cubes_and_rings_are_closed() {
        for detail in [1, 5, 48] {
            let mesh = check(Shape::Cube, detail);
            let (low, high) = mesh.bounds();
            assert!((high - low - 1.0).abs().max_element() < 1e-12 && mesh.volume() > 0.95, "{}", mesh.volume());
        }
        for detail in [3, 4, 17, 160] {
            let mesh = check(Shape::Torus, detail);
            // One handle: Euler characteristic 0, so that there are half as many vertices as triangles.
            assert_eq!(2 * mesh.positions.len(), mesh.triangles.len());
            let whole = 2.0 * std::f64::consts::PI.powi(2) * TUBE * TUBE;
            assert!(mesh.volume() < whole && (detail < 160 || mesh.volume() > 0.99 * whole), "{}", mesh.volume());
        }
    }

    #[test]
    fn planes_are_open_and_face_up() {
        for detail in [1, 2, 33] {
            let mesh = Shape::Plane.build(detail);
            let edges = Edges::of(&mesh.triangles);
            assert_eq!((edges.open, edges.crowded), (mesh.open_edges, 0));
            let areas = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face));
            let areas: Vec<DVec3> = areas.map(|[a, b, c]| (b - a).cross(c - a) / 2.0).collect();
            assert!(areas.iter().all(|area| area.y > 0.0 && area.x == 0.0 && area.z == 0.0));
            assert!((areas.iter().sum::<DVec3>() - DVec3::Y).length() < 1e-12);
        }
    }

    #[test]
    fn candles_are_closed_and_hollow_on_top() {
        for detail in [16, 17, 50, 192] {
            let mesh = check(Shape::Candle, detail);
            let (low, high) = mesh.bounds();
            assert!(low.y == 0.0 && high.y > 1.0 && high.y < 1.04, "{low} {high}");
            let hollow = mesh.positions.iter().filter(|p| p.x == 0.0 && p.z == 0.0).map(|p| p.y);
            assert_eq!(hollow.collect::<Vec<_>>(), [0.0, 0.84]);
        }
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn busts_are_closed_and_stand_upright() {
        for detail in [64, 66, 93, 128, 192] {
            let mesh = check(Shape::Bust, detail);
            let (low, high) = mesh.bounds();
            let extent = high - low;
            assert!(extent.y > 1.75 && extent.y < 1.9 && extent.x < 1.3, "{extent}");
            let faces = mesh.triangles.len();
            assert!(detail < 128 || (20_000..120_000).contains(&faces), "{faces}");
        }
    }
}
