//! Stage `coarse_solve`: how bright the object will be, from a coarse solution at a few receivers. The error allowed
//! per link is proportional to it. It depends on this frame only, never on the last one: results must not depend on
//! history.

use rayon::prelude::*;

use crate::dipole::derivatives::{ClusterMoments, GroupProfile};
use crate::dipole::distance2;
use crate::error::Result;
use crate::layout::{BufferId, COARSE_SAMPLES, GROUP_SIZE, Moment, NONE, Sample};
use crate::state::{Field, Pass, Role, Scope, Size, Stage, State, Tolerance, wide};

/// Number of samples of each kind: drawn evenly among the faces, and drawn by the light that enters.
const HALF: usize = COARSE_SAMPLES / 2;
// Each invocation of kernel `root` takes four samples.
const _: () = assert!(COARSE_SAMPLES == 4 * GROUP_SIZE as usize);

const SAMPLE: &[Field] = &[
    Field { name: "chance", relative: 1e-5, floor: 0.0, of: "" },
    Field { name: "value", relative: 2e-4, floor: 1e-25, of: "" },
    Field { name: "light", relative: 2e-5, floor: 1e-30, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "coarse_solve",
    about: "root mean square of the radiosity, from a coarse solution at 256 receivers",
    equation: "B_rms^2 = sum_k B_k^2 A_k / (n q_k sum A), clusters taken as one where chi < 0.3",
    writes: &[
        (BufferId::samples, Role::Output, Tolerance::Fields(SAMPLE)),
        (BufferId::reference_level, Role::Update, Tolerance::Float { relative: 2e-4, floor: 1e-25 }),
    ],
    reason: "the walk is decided exactly; its sum has some hundred terms of f32 rounding, the quadrupoles of either sign",
    sizes: &[
        (BufferId::samples, Size::Elements(|_| COARSE_SAMPLES)),
        (BufferId::reference_level, Size::Elements(|_| 1)),
    ],
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, at: Scope) {
    let (base, _) = state.part(BufferId::moments, at);
    let group = state.object(at).groups[at.group];
    let data = &mut state.data;
    let (moments, spreads) = (&data.moments[base..], &data.second_moments[base..]);
    let jets = GroupProfile::new(&data.object_params[0], group.channels);

    let faces = data.triangles.len() as u32;
    let drawn = |k: usize| {
        let even = ((k as f32 + 0.5) * (1.0 / HALF as f32) * faces as f32) as u32;
        let leaf = if k < HALF {
            data.leaves[even.min(faces - 1) as usize] as usize
        } else {
            by_light(data, moments, k - HALF)
        };
        let x = data.clusters[leaf].center;
        let mut sum = [0.0; 3];
        let (mut node, end) = (0, data.topology.len());
        while node < end {
            let (m, s) = (&moments[node], &spreads[node]);
            let skip = data.topology[node].skip as usize;
            let (lit, leaf) = (m.weight > 0.0, skip == node + 1);
            let far = distance2(x, m.center) >= s.coarse * s.coarse;
            if lit && (far || leaf) {
                let area = f64::from(data.clusters[node].area).max(1e-30);
                for c in jets.channels() {
                    let near = jets.plane(c) * f64::from(m.weight) / area;
                    let center = jets.at(c, wide(x).distance_squared(wide(m.center))).value * f64::from(m.weight);
                    sum[c] += if far { jets.link(c, &ClusterMoments::new(m, s), wide(x), 2) } else { center.min(near) };
                }
            }
            node = if lit && !far && !leaf { node + 1 } else { skip };
        }
        let whole = moments[0].weight;
        let light = if whole > 0.0 { f64::from(moments[leaf].weight) / f64::from(whole) } else { 0.0 };
        let chance = 0.5 / f64::from(faces) + 0.5 * light;
        let (area, all) = (f64::from(data.clusters[leaf].area), f64::from(data.clusters[0].area));
        let mean = all / f64::from(faces);
        let entering = f64::from(moments[leaf].weight) * all;
        let of_mean = if area * f64::from(whole) > 0.0 { entering / (area * f64::from(whole)) } else { 0.0 };
        let share = if mean > 0.0 { of_mean.powi(2) * area / mean } else { 0.0 };
        Sample {
            face: data.topology[leaf].face,
            chance: chance as f32,
            value: sum.map(|v| v.max(0.0) as f32),
            light: (share / (chance * f64::from(faces))) as f32,
        }
    };
    data.samples = (0..COARSE_SAMPLES).into_par_iter().map(drawn).collect();

    let mean = f64::from(data.clusters[0].area) / f64::from(faces);
    for c in jets.channels() {
        let term = |one: &Sample| {
            let area = f64::from(data.clusters[data.leaves[one.face as usize] as usize].area);
            let share = if mean > 0.0 { area / mean } else { 0.0 };
            f64::from(one.value[c]).powi(2) * share / (f64::from(one.chance) * f64::from(faces))
        };
        let square = data.samples.iter().map(term).sum::<f64>() / COARSE_SAMPLES as f64;
        data.reference_level[0][c] = square.sqrt().max(1e-30) as f32;
    }
}

/// The leaf of sample `k` of those drawn by the light: the one at share (k + 1/2) / `HALF` of the cumulative light, in
/// `f32`.
fn by_light(data: &crate::layout::Buffers, moments: &[Moment], k: usize) -> usize {
    let mut target = moments[0].weight * ((k as f32 + 0.5) * (1.0 / HALF as f32));
    let mut node = 0;
    while data.topology[node].face == NONE {
        let (left, right) = (node + 1, data.topology[node + 1].skip as usize);
        let before = moments[left].weight;
        if target < before || moments[right].weight.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            node = left;
        } else {
            target -= before;
            node = right;
        }
    }
    node
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let constants = [pass.object().groups[pass.at.group].channels];
    pass.dispatch(Some("sample"), &constants, &[], COARSE_SAMPLES)?;
    pass.dispatch(Some("root"), &constants, &[], 1)
}
