//! Stage `mean_irradiance`: the irradiance of each cluster, the area-weighted mean over its faces. (Section 3.2
//! averages the children; without their areas that would not conserve power.)

use crate::error::Result;
use crate::layout::{BufferId, NONE};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, Update, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "mean_irradiance",
    about: "area-weighted mean irradiance of every cluster",
    equation: "Mertens et al. 2003, section 3.2, weighted: sum A_k E_k / sum A_k",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::cluster_irradiance, Role::Output, Tolerance::Float { relative: 1e-5, floor: 1e-6 }),
    ],
    reason: "a weighted mean a level, some 40 levels of f32 rounding",
    runs: Update::light,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;

    let mean = |power, area| if area > 0.0 { narrow(power / area) } else { [0.0; 3] };

    // Power and area of each node, summed from its faces.
    let nodes = data.topology.len();
    let mut power = vec![glam::DVec3::ZERO; nodes];
    let mut area = vec![0.0; nodes];
    for node in (0..nodes).rev() {
        let place = data.topology[node];
        if place.face == NONE {
            let (l, r) = (node + 1, data.topology[node + 1].skip as usize);
            power[node] = power[l] + power[r];
            area[node] = area[l] + area[r];
        } else {
            area[node] = f64::from(data.clusters[node].area);
            power[node] = area[node] * wide(data.irradiance[place.face as usize]);
        }
    }
    data.cluster_irradiance = power.iter().zip(&area).map(|(&power, &area)| mean(power, area)).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(Some("leaf"), &[], &[], pass.object().count.faces)?;
    pass.climb("cluster", &[])
}
