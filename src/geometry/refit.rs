//! Stage `refit`: recomputes from positions the boxes, centroids, vector areas and second moments of faces and
//! clusters, bottom-up, the spheres of blocks, and vertex normals. Runs whenever the shape changes.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{Block, Bounds, BufferId, Buffers, Cluster, NONE, ObjectParams, Sphere, Topology};
use crate::scene::vertex_normal;
use crate::state::{Field, Pass, Role, Rounding, Scope, Size, Stage, State, Tolerance, narrow, wide};

/// Tolerances of clusters: centres relative to the extent, areas and second moments to themselves, vector areas to
/// the area; [`of_clusters`] adds to them.
const CLUSTER: &[Field] = &[
    Field { name: "center", relative: 0.0, floor: 2e-6, of: "" },
    Field { name: "area", relative: 5e-6, floor: 0.0, of: "" },
    Field { name: "normal", relative: 0.0, floor: 5e-6, of: "area" },
    Field { name: "moment_trace", relative: 5e-5, floor: 0.0, of: "" },
];

/// Tolerances of vertex normals, which are unit vectors.
const NORMAL: &[Field] = &[Field { name: "", relative: 1e-5, floor: 1e-5, of: "" }];

/// The rounding of triangles' areas in clusters.
static IN_CLUSTERS: Rounding = Rounding {
    about: "3 x 2^-24 times the two shorter edges of each triangle",
    fields: &["center", "area", "normal", "moment_trace"],
    of: of_clusters,
};
/// The rounding of triangles' areas in vertex normals.
static IN_NORMALS: Rounding = Rounding { fields: &[""], of: of_normals, ..IN_CLUSTERS };

/// Tolerances of a block's sphere: centre and radius relative to the extent.
pub const SPHERE: &[Field] = &[
    Field { name: "center", relative: 0.0, floor: 4e-6, of: "" },
    Field { name: "radius", relative: 1e-5, floor: 4e-6, of: "" },
    Field { name: "relative_moment", relative: 1e-3, floor: 0.0, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "refit",
    about: "boxes, centroids, vector areas and second moments of faces and clusters; vertex normals",
    equation: "Mertens et al. 2003, section 5.1.1: A' is the length of the vector area",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::bounds, Role::Output, Tolerance::Exact),
        (BufferId::clusters, Role::Output, Tolerance::Rounded(CLUSTER, &IN_CLUSTERS)),
        (BufferId::receiver_positions, Role::Output, Tolerance::Float { relative: 0.0, floor: 4e-6 }),
        (BufferId::spheres, Role::Output, Tolerance::Fields(SPHERE)),
        (BufferId::normals, Role::Output, Tolerance::Rounded(NORMAL, &IN_NORMALS)),
    ],
    reason: "boxes are minima and maxima; sums climb some 40 levels of f32 rounding, 40 x 2^-24 = 2.4e-6 of the \
             extent and of the area; a sliver's area is a cross product that cancels: of edges rounded at u = 2^-24 of \
             themselves, each product is off by 3 u of itself, together by less than 2.2 u times the edges' lengths, \
             however small their difference",
    sizes: &[(BufferId::receiver_positions, Size::Elements(places))],
    ..super::stage(cpu, gpu)
};

/// Elements of `receiver_positions`: one per receiver if there are blocks, else none.
fn places(state: &State) -> usize {
    let extent = state.extent();
    if extent.blocks > 0 { extent.receivers } else { 0 }
}

/// The next node and the triangle of a node's box, as indices over the trees of all objects.
fn way(params: &ObjectParams, place: Topology) -> Bounds {
    let next = if place.skip == params.nodes { params.next_node } else { params.first_node + place.skip };
    let face = if place.face == NONE { NONE } else { params.first_face + place.face };
    Bounds { next, face, ..Bounds::default() }
}

/// Area-weighted sums over the faces below a node.
#[derive(Clone, Copy, Default)]
struct Sums {
    area: f64,
    center: DVec3,
    normal: DVec3,
    moment_trace: f64,
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let (nodes, params) = (data.topology.len(), &data.object_params[0]);
    let corner = |face: usize, k: usize| wide(data.positions[data.triangles[face][k] as usize]);

    // Children come after their parent, so one backward sweep sees them first.
    let mut sums = vec![Sums::default(); nodes];
    let mut bounds = vec![Bounds::default(); nodes];
    for node in (0..nodes).rev() {
        let place = data.topology[node];
        if place.face != NONE {
            let face = place.face as usize;
            let (a, b, c) = (corner(face, 0), corner(face, 1), corner(face, 2));
            let normal = 0.5 * (b - a).cross(c - a);
            let edges = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
            sums[node] = Sums { area: normal.length(), center: (a + b + c) / 3.0, normal, moment_trace: edges / 36.0 };
            bounds[node] = Bounds { low: narrow(a.min(b).min(c)), high: narrow(a.max(b).max(c)), ..way(params, place) };
            continue;
        }
        let (l, r) = (node + 1, data.topology[node + 1].skip as usize);
        let (left, right) = (sums[l], sums[r]);
        let area = left.area + right.area;
        let half = if area > 0.0 { right.area / area } else { 0.5 };
        let center = left.center.lerp(right.center, half);
        let about = |part: Sums| part.area * (part.moment_trace + part.center.distance_squared(center));
        let moment_trace = if area > 0.0 { (about(left) + about(right)) / area } else { 0.0 };
        sums[node] = Sums { area, center, normal: left.normal + right.normal, moment_trace };
        let merge = |f: fn(DVec3, DVec3) -> DVec3, p: [f32; 3], q: [f32; 3]| narrow(f(wide(p), wide(q)));
        bounds[node] = Bounds {
            low: merge(DVec3::min, bounds[l].low, bounds[r].low),
            high: merge(DVec3::max, bounds[l].high, bounds[r].high),
            ..way(params, place)
        };
    }
    data.bounds = bounds;
    data.clusters = sums
        .par_iter()
        .map(|s| Cluster {
            center: narrow(s.center),
            area: s.area as f32,
            normal: narrow(s.normal),
            moment_trace: s.moment_trace as f32,
        })
        .collect();

    // The bounding spheres of the blocks' receivers.
    let disc = disc(sums.first().map_or(0.0, |root| root.area), params.usual_blocks);
    if params.by_pixel == 0 && params.blocks > 0 {
        let center = |&leaf: &u32| sums[leaf as usize].center;
        data.receiver_positions = data.leaves.iter().map(|leaf| narrow(center(leaf))).collect();
        let of_block = |block| sphere(block, disc, |face| center(&data.leaves[face]));
        data.spheres = data.blocks.iter().map(of_block).collect();
    }

    // Vertex normals from the triangles around each vertex, or of whole triangles that were divided.
    if state.objects[0].whole_normals {
        data.normals.clone_from(&data.whole_normals);
        return;
    }
    let around = |v: usize| &data.corners[data.corner_starts[v] as usize..data.corner_starts[v + 1] as usize];
    data.normals = (0..data.corner_starts.len() - 1)
        .map(|v| {
            let faces = around(v).iter().map(|&f| &sums[data.leaves[f as usize] as usize]);
            narrow(vertex_normal(faces.map(|face| (face.normal, face.area))).normalize_or_zero())
        })
        .collect();
}

/// Mean square distance from the centre over a flat disc of a block's mean area.
#[must_use]
pub fn disc(area: f64, blocks: u32) -> f64 {
    f64::max(area / (TAU * f64::from(blocks)), 1e-30)
}

/// The bounding sphere of a block's receivers; their mean square distance from its centre is given relative to that
/// of a usual block, [`disc`].
pub fn sphere(block: &Block, disc: f64, center_of: impl Fn(usize) -> DVec3) -> Sphere {
    let points = || (block.first as usize..(block.first + block.count) as usize).map(&center_of);
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    let center = 0.5 * (low + high);
    let squares = || points().map(|x| x.distance_squared(center));
    let moment = squares().sum::<f64>() / f64::from(block.count);
    let radius = squares().fold(0.0, f64::max).sqrt();
    Sphere { center: narrow(center), radius: radius as f32, relative_moment: (moment / disc) as f32 }
}

/// A bound on the rounding of a triangle's area, from its two shorter edges: see the stage's reason.
fn rounding(data: &Buffers, face: usize) -> f64 {
    let [a, b, c] = data.triangles[face].map(|vertex| wide(data.positions[vertex as usize]));
    let mut edges = [a.distance(b), b.distance(c), c.distance(a)];
    edges.sort_by(f64::total_cmp);
    3.0 * 0.5f64.powi(24) * edges[0] * edges[1]
}

/// Errors of centre, area, vector area and second moment of every cluster by the rounding d of its triangles' areas.
/// For a sum A with means c and m they are at most, as A may be as small as A - sum d,
///   sum d |c_i - c| / (A - sum d),  sum d,  sum d,  and  sum d |m_i + |c_i - c|^2 - m| / (A - sum d).
fn of_clusters(state: &State) -> Vec<f64> {
    let data = &state.data;
    /// Sums over triangles of d, of d times the centre, and of d times the second moment about the origin.
    #[derive(Clone, Copy, Default)]
    struct Off(f64, DVec3, f64);
    let mut sums = vec![Off::default(); data.topology.len()];
    let mut allowed = vec![0.0; 4 * sums.len()];
    for object in &state.objects {
        let first = object.first.nodes;
        for node in (first..first + object.count.nodes).rev() {
            let (cluster, face) = (&data.clusters[node], data.topology[node].face);
            let (center, moment) = (wide(cluster.center), f64::from(cluster.moment_trace));
            let mut off = [0.0; 2];
            if face == NONE {
                let (left, right) = (sums[node + 1], sums[first + data.topology[node + 1].skip as usize]);
                let Off(sum, places, squares) = Off(left.0 + right.0, left.1 + right.1, left.2 + right.2);
                sums[node] = Off(sum, places, squares);
                let about = (squares - 2.0 * center.dot(places) + sum * center.length_squared()).max(0.0);
                let least = f64::from(cluster.area) - sum;
                let over = |x: f64| if x == 0.0 { 0.0 } else { x / least.max(0.0) };
                off = [over((sum * about).sqrt()), over(about + sum * moment)];
            } else {
                let d = rounding(data, object.first.faces + face as usize);
                sums[node] = Off(d, d * center, d * (moment + center.length_squared()));
            }
            allowed[4 * node..][..4].copy_from_slice(&[off[0], sums[node].0, sums[node].0, off[1]]);
        }
    }
    allowed
}

/// Errors of vertex normals by the rounding of the areas around them: a sum's direction is off by at most twice that
/// rounding over the sum.
fn of_normals(state: &State) -> Vec<f64> {
    let data = &state.data;
    let mut allowed = vec![0.0; data.normals.len()];
    for object in &state.objects {
        let (first, count) = (object.first.vertices, object.count.vertices);
        for (vertex, allowed) in allowed.iter_mut().enumerate().skip(first).take(count) {
            let around = data.corner_starts[vertex] as usize..data.corner_starts[vertex + 1] as usize;
            let faces = data.corners[3 * object.first.faces..][around].iter().map(|face| {
                let face = object.first.faces + *face as usize;
                let cluster = &data.clusters[object.first.nodes + data.leaves[face] as usize];
                (wide(cluster.normal), f64::from(cluster.area), face)
            });
            let sum = vertex_normal(faces.clone().map(|(normal, area, _)| (normal, area)));
            let off: f64 = faces.map(|(.., face)| rounding(data, face)).sum();
            *allowed = if sum == DVec3::ZERO { 0.0 } else { (2.0 * off / sum.length()).min(2.0) };
        }
    }
    allowed
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let count = pass.object().count;
    let receives = count.blocks > 0 && !pass.object().by_pixel;
    pass.dispatch(Some("leaf"), &[u32::from(receives)], &[], count.faces)?;
    pass.climb("cluster", &[])?;
    if receives {
        pass.dispatch(Some("block"), &[], &[], count.blocks)?;
    }
    let known = pass.object().whole_normals;
    pass.dispatch(Some("normal"), &[u32::from(known)], &[], count.vertices)
}
