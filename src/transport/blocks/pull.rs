//! Stage `pull`: moments of the light that enters every cluster: its sum W, its centroid, and its second moments.
//! (Section 3.2 of the paper averages irradiance; with moments up to the second, few links are enough.)

use glam::DVec3;

use crate::dipole::form_factor::ladder::chi_distance;
use crate::error::Result;
use crate::layout::{BufferId, COARSE_CHI, Moment, NONE, SecondMoments};
use crate::state::{Carrier, Field, Pass, Role, Scope, Stage, State, Tolerance, Update, narrow, wide};

/// Tolerances: of the weight relative to its value, of the centroid relative to the object's extent.
const MOMENT: &[Field] = &[
    Field { name: "center", relative: 0.0, floor: 4e-6, of: "" },
    Field { name: "weight", relative: 5e-5, floor: 0.0, of: "" },
];

/// Tolerances of second moments: relative to the value, plus a share of the radius.
const SECOND_MOMENTS: &[Field] = &[
    Field { name: "diagonal", relative: 1e-4, floor: 2e-6, of: "radius" },
    Field { name: "mixed", relative: 1e-4, floor: 2e-6, of: "radius" },
    Field { name: "radius", relative: 1e-4, floor: 4e-6, of: "" },
    Field { name: "coarse", relative: 1e-3, floor: 1e-5, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "pull",
    about: "moments of the light entering every cluster: sum, centroid, second moments; for diffusion, of its area",
    equation: "W = sum A_k E_k, c = sum A_k E_k x_k / W, Q = sum A_k E_k [(x_k-c)(x_k-c)^T + M_k] / W",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::moments, Role::Output, Tolerance::Fields(MOMENT)),
        (BufferId::second_moments, Role::Output, Tolerance::Fields(SECOND_MOMENTS)),
    ],
    reason: "sums climb some 40 levels of f32 rounding, 40 x 2^-24 = 2.4e-6 of the extent",
    carriers: &[Carrier::Blocks, Carrier::Diffusion],
    runs: Update::light,
    ..super::stage(cpu, gpu)
};

/// Sums over the faces below a node.
#[derive(Clone, Copy, Default)]
struct Sums {
    weight: f64,
    center: DVec3,
    diagonal: DVec3,
    mixed: DVec3,
    radius: f64,
}

fn cpu(state: &mut State, at: Scope) {
    let (base, _) = state.part(BufferId::moments, at);
    let (lead, order) = (state.object(at).groups[at.group].lead as usize, state.moment_order(at));
    let by_area = state.object(at).solves();
    let data = &mut state.data;
    let nodes = data.topology.len();
    let products = |v: DVec3| (v * v, DVec3::new(v.y * v.z, v.z * v.x, v.x * v.y));

    let mut sums = vec![Sums::default(); nodes];
    for node in (0..nodes).rev() {
        let place = data.topology[node];
        if place.face != NONE {
            let face = place.face as usize;
            let corner = data.triangles[face].map(|v| wide(data.positions[v as usize]));
            let center = wide(data.clusters[node].center);
            let mut sum = Sums { center, ..Sums::default() };
            for k in 0..3 {
                let (diagonal, mixed) = products(corner[(k + 1) % 3] - corner[k]);
                sum.diagonal += diagonal / 36.0;
                sum.mixed += mixed / 36.0;
                sum.radius = sum.radius.max(corner[k].distance(center));
            }
            let irradiance = if by_area { 1.0 } else { f64::from(data.irradiance[face][lead]) };
            sum.weight = f64::from(data.clusters[node].area) * irradiance;
            sums[node] = sum;
            continue;
        }
        let (l, r) = (sums[node + 1], sums[data.topology[node + 1].skip as usize]);
        let weight = l.weight + r.weight;
        let share = if weight > 0.0 { r.weight / weight } else { 0.5 };
        let center = if order == 0 { wide(data.clusters[node].center) } else { l.center.lerp(r.center, share) };
        let about = |part: Sums| {
            let (diagonal, mixed) = products(part.center - center);
            (part.diagonal + diagonal, part.mixed + mixed)
        };
        let ((l2, lm), (r2, rm)) = (about(l), about(r));
        let spheres = (l.center.distance(center) + l.radius).max(r.center.distance(center) + r.radius);
        let (low, high) = (wide(data.bounds[node].low), wide(data.bounds[node].high));
        let corner = (center - low).max(high - center).length();
        sums[node] = Sums {
            weight,
            center,
            diagonal: l2.lerp(r2, share),
            mixed: lm.lerp(rm, share),
            radius: spheres.min(corner),
        };
    }

    let sigma = data.object_params[0].sigma.map(f64::from);
    for (node, sum) in sums.iter().enumerate() {
        let farthest = chi_distance(sum.diagonal.element_sum(), sigma, COARSE_CHI);
        data.moments[base + node] = Moment { center: narrow(sum.center), weight: sum.weight as f32 };
        data.second_moments[base + node] = SecondMoments {
            diagonal: narrow(sum.diagonal),
            radius: sum.radius as f32,
            mixed: narrow(sum.mixed),
            coarse: (sum.radius + farthest) as f32,
        };
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let (lead, order) = (pass.object().groups[pass.at.group].lead, pass.state.moment_order(pass.at));
    let lead = if pass.object().solves() { NONE } else { lead };
    pass.dispatch(Some("leaf"), &[lead], &[], pass.object().count.faces)?;
    pass.climb("cluster", &[order])
}
