//! Stage `plane_fit`: for each vertex of an object with layers, the plane through which light enters around it
//! (section 2.2): least squares over the vertices within `object_params.fit_radius`, which is -ln(epsilon) / sigma_t
//! of the first layer (equation 8).
//!
//! A plane is a unit normal NS and the height d of the plane over the vertex V along it: V + d NS lies on it.
//! (Equation 14 measures along the vertex normal; that length has no sign, and no bound where the normals differ
//! much.) The tangent plane takes its place where the vertices define no plane: fewer than three of them, or nearly
//! on a line (middle moment below 1 to 5 % of the largest), or as thick as wide (least moment above 25 to 50 % of the
//! middle one), or far from the tangent plane (cosine below 0.5 to 0.8). Within these ranges the two are blended, so
//! that the result is continuous.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{Bounds, BufferId, NONE, VertexMoments};
use crate::state::{Granularity, Pass, Role, Scope, Stage, State, Tolerance, Update, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "plane_fit",
    about: "plane that fits the surface around each vertex of an object with layers",
    equation: "Francois et al. 2006, equations 7, 8, 14",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::vertex_moments, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::planes, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-4 }),
        (BufferId::cut_short, Role::Update, Tolerance::Exact),
    ],
    reason: "centroids are sums of positions, each rounded to 6e-8; an axis turns by the moments' rounding, 1e-7, over \
             their difference, at least 0.005 of the largest",
    granularity: Granularity::Object,
    runs: Update::shape,
    ..super::stage(cpu, gpu)
};

/// Number of points, sum of positions and sum of their outer products, relative to some origin.
#[derive(Clone, Copy)]
struct Sums {
    count: f64,
    first: DVec3,
    second: DMat3,
}

impl Sums {
    const NONE: Self = Self { count: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    fn point(p: DVec3) -> Self {
        Self { count: 1.0, first: p, second: DMat3::from_cols(p * p.x, p * p.y, p * p.z) }
    }

    fn and(self, other: Self) -> Self {
        Self { count: self.count + other.count, first: self.first + other.first, second: self.second + other.second }
    }

    /// Centroid, and second moments about it.
    fn central(&self) -> (DVec3, DMat3) {
        let center = if self.count > 0.0 { self.first / self.count } else { DVec3::ZERO };
        (center, self.second - DMat3::from_cols(center * center.x, center * center.y, center * center.z) * self.count)
    }

    /// The same sums relative to the origin `place`.
    fn from(&self, place: DVec3) -> Self {
        let (center, central) = self.central();
        let d = center - place;
        let shift = DMat3::from_cols(d * d.x, d * d.y, d * d.z) * self.count;
        Self { count: self.count, first: d * self.count, second: central + shift }
    }
}

/// Unit axis of the least moment, and the three moments in ascending order. Eigenvalues by Cardano's formula; the
/// axis is the longest cross product of two columns of `moments` minus the least eigenvalue.
fn least_axis(moments: DMat3) -> (DVec3, [f64; 3]) {
    let mean = (moments.x_axis.x + moments.y_axis.y + moments.z_axis.z) / 3.0;
    let rest = moments - DMat3::from_diagonal(DVec3::splat(mean));
    let size = (rest.x_axis.length_squared() + rest.y_axis.length_squared() + rest.z_axis.length_squared()) / 6.0;
    if size <= 0.0 {
        return (DVec3::Z, [mean; 3]);
    }
    let root = size.sqrt();
    let angle = (rest.determinant() / (2.0 * size * root)).clamp(-1.0, 1.0).acos() / 3.0;
    let value = |k: f64| mean + 2.0 * root * (angle + k * std::f64::consts::TAU / 3.0).cos();
    let mut values = [value(0.0), value(1.0), value(2.0)];
    values.sort_by(f64::total_cmp);
    let left = moments - DMat3::from_diagonal(DVec3::splat(values[0]));
    let across = [left.x_axis.cross(left.y_axis), left.y_axis.cross(left.z_axis), left.z_axis.cross(left.x_axis)];
    let longest = across.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    (longest.unwrap_or(DVec3::Z).normalize_or(DVec3::Z), values)
}

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The plane fitted to points relative to a vertex with normal `normal`: its unit normal and its height.
fn plane(sums: &Sums, normal: DVec3) -> (DVec3, f64) {
    let (center, moments) = sums.central();
    let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
    if sums.count < 3.0 || trace <= 0.0 {
        return (normal, 0.0);
    }
    let (axis, [least, middle, most]) = least_axis(moments * (1.0 / trace));
    let along = axis.dot(normal);
    let trust = (1.0 - smoothstep(0.25, 0.5, least.max(0.0) / middle.max(1e-30)))
        * smoothstep(0.01, 0.05, middle / most)
        * smoothstep(0.5, 0.8, along.abs());
    let fitted = normal.lerp(axis * if along < 0.0 { -1.0 } else { 1.0 }, trust).normalize_or_zero();
    (fitted, trust * center.dot(fitted))
}

/// Squares of the least and largest distance from a point to a box; in `f32`, so that host and device count the same
/// vertices.
fn distances(place: [f32; 3], bounds: &Bounds) -> [f32; 2] {
    let each = |f: fn(f32, f32) -> f32| -> f32 {
        let d: [f32; 3] = std::array::from_fn(|k| f(bounds.low[k] - place[k], bounds.high[k] - place[k]));
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    };
    [each(|low, high| low.max(-high).max(0.0)), each(|low, high| low.abs().max(high.abs()))]
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let params = &data.object_params[0];
    let nodes = data.topology.len();
    let position = |vertex: u32| data.positions[vertex as usize];
    let owned = |face: u32| {
        let own = move |v: &u32| data.corners[data.corner_starts[(v - params.first_vertex) as usize] as usize] == face;
        data.triangles[face as usize].into_iter().filter(own)
    };

    // Sums of each cluster, from the leaves to the root.
    let mut sums = vec![Sums::NONE; nodes];
    for node in (0..nodes).rev() {
        let place = data.topology[node];
        sums[node] = match place.face {
            NONE => sums[node + 1].and(sums[data.topology[node + 1].skip as usize]),
            face => owned(face).fold(Sums::NONE, |sum, v| sum.and(Sums::point(wide(position(v))))),
        };
    }

    // Sums within the radius of a vertex, from whole clusters where they lie inside.
    let r2 = params.fit_radius * params.fit_radius;
    let around = |here: [f32; 3]| {
        let (mut sum, mut node) = (Sums::NONE, 0);
        while node < nodes {
            let [nearest, farthest] = distances(here, &data.bounds[node]);
            let place = data.topology[node];
            if nearest <= r2 && farthest <= r2 {
                sum = sum.and(sums[node].from(wide(here)));
            } else if nearest <= r2 && place.face != NONE {
                for v in owned(place.face) {
                    let d: [f32; 3] = std::array::from_fn(|k| position(v)[k] - here[k]);
                    if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= r2 {
                        sum = sum.and(Sums::point(wide(position(v)) - wide(here)));
                    }
                }
            } else if nearest <= r2 {
                node += 1;
                continue;
            }
            node = place.skip as usize;
        }
        sum
    };
    let fit = |vertex: usize| {
        let here = position(params.first_vertex + vertex as u32);
        let (normal, height) = plane(&around(here), wide(data.normals[vertex]));
        let [x, y, z] = narrow(normal);
        [x, y, z, height as f32]
    };
    let planes = (0..params.vertices as usize).into_par_iter().map(fit).collect();
    let crowd = |sums: &Sums| {
        let (center, m) = sums.central();
        VertexMoments {
            count: sums.count as f32,
            center: narrow(center),
            diagonal: [m.x_axis.x, m.y_axis.y, m.z_axis.z].map(|x| x as f32),
            mixed: [m.y_axis.z, m.z_axis.x, m.x_axis.y].map(|x| x as f32),
        }
    };
    state.data.vertex_moments = sums.iter().map(crowd).collect();
    state.data.planes = planes;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(Some("leaf"), &[], &[], pass.object().count.faces)?;
    pass.climb("cluster", &[])?;
    pass.dispatch(Some("fit"), &[], &[], pass.object().count.vertices)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums_of(points: &[DVec3]) -> Sums {
        points.iter().fold(Sums::NONE, |sum, &p| sum.and(Sums::point(p)))
    }

    /// Points of a square grid with heights from a function of x and y.
    fn grid(height: impl Fn(f64, f64) -> f64) -> Vec<DVec3> {
        let line = |i: i32| 0.1 * f64::from(i);
        let point = |i: i32, j: i32| DVec3::new(line(i), line(j), height(line(i), line(j)));
        (-5..=5).flat_map(|i| (-5..=5).map(move |j| (i, j))).map(|(i, j)| point(i, j)).collect()
    }

    #[test]
    fn a_plane_is_found() {
        let (normal, height) = plane(&sums_of(&grid(|x, y| 0.3 * x - 0.2 * y - 0.05)), DVec3::Z);
        let expected = DVec3::new(-0.3, 0.2, 1.0).normalize();
        assert!((normal - expected).length() < 1e-9, "{normal}");
        // The height is measured along the plane's normal: 0.05 below, times the cosine.
        assert!((height + 0.05 * expected.z).abs() < 1e-9, "{height}");
        assert_eq!(plane(&sums_of(&grid(|_, _| 0.0)), -DVec3::Z).0, -DVec3::Z);
    }

    #[test]
    fn on_a_hill_it_lies_below_the_top() {
        let (normal, height) = plane(&sums_of(&grid(|x, y| -0.2 * (x * x + y * y))), DVec3::Z);
        // The mean of -0.2 (x^2 + y^2) over the grid: -0.4 * 0.1.
        assert!((normal - DVec3::Z).length() < 1e-9 && (height + 0.04).abs() < 1e-9, "{normal} {height}");
    }

    #[test]
    fn where_vertices_tell_no_plane_it_is_the_tangent_one() {
        let tangent = (DVec3::Z, 0.0);
        assert_eq!(plane(&sums_of(&[DVec3::X, DVec3::Y]), DVec3::Z), tangent);
        assert_eq!(plane(&sums_of(&[DVec3::X, DVec3::X, DVec3::X]), DVec3::Z), tangent);
        let line: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i), 0.0, 0.1 * f64::from(i % 2))).collect();
        assert_eq!(plane(&sums_of(&line), DVec3::Z), tangent);
        let corners = [1.0, -1.0].map(|x| [1.0, -1.0].map(|y| [1.0, -1.0].map(|z| DVec3::new(x, y, z))));
        let cube: Vec<DVec3> = corners.into_iter().flatten().flatten().collect();
        assert_eq!(plane(&sums_of(&cube), DVec3::Z), tangent);
        assert_eq!(plane(&sums_of(&grid(|_, _| 0.0)), DVec3::X), (DVec3::X, 0.0));
    }

    #[test]
    fn sums_from_elsewhere_are_those_of_the_points_seen_from_there() {
        let (points, place) = (grid(|x, y| x * y + 0.1), DVec3::new(3.0, -1.0, 0.5));
        let moved: Vec<DVec3> = points.iter().map(|p| *p - place).collect();
        let (a, b) = (sums_of(&points).from(place), sums_of(&moved));
        assert_eq!(a.count, b.count);
        assert!((a.first - b.first).length() < 1e-9);
        assert!((a.second - b.second).to_cols_array().iter().all(|x| x.abs() < 1e-9));
    }
}
