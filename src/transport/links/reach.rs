//! Stage `reach`: how far away a triangle must be for each quadrature rule of the ladder, and a cluster for one sample
//! instead of its projection. Turning the criterion chi into squared distances in advance keeps square roots out of the
//! decisions.

use rayon::prelude::*;

use crate::dipole::profile::Dipole;
use crate::error::Result;
use crate::layout::{BufferId, FAINTEST};
use crate::state::{Carrier, Distance, Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "reach",
    about: "squared distances beyond which 1, 3, 6 or 12 area points suffice for a triangle",
    equation: "chi = tau q2(sigma s) / (2 s^2) solved for s, with q2(a) <= 15 + 5a + a^2",
    writes: &[
        (BufferId::reach, Role::Output, Tolerance::Float { relative: 2e-5, floor: 1e-7 }),
        (BufferId::cluster_reach, Role::Output, Tolerance::Float { relative: 2e-5, floor: 1e-7 }),
    ],
    reason: "a short chain of f32 operations; k = 2 chi / tau - sigma^2 cancels where both are large",
    sizes: &[(
        BufferId::cluster_reach,
        Size::Elements(|state| if state.method.projected { state.extent().nodes } else { 0 }),
    )],
    carriers: &[Carrier::Links, Carrier::Brute],
    runs: |update| if update.keeps { update.material() || update.change.relink } else { update.transport() },
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let params = data.object_params[0];
    let dipoles = [0, 1, 2].map(|channel| Dipole::of(&params, channel));
    let chi = params.ladder.map(f64::from);
    let displaced = state.distance == Distance::Table1;
    data.reach = data
        .leaves
        .par_iter()
        .map(|&leaf| {
            let tau = f64::from(data.clusters[leaf as usize].moment_trace);
            chi.map(|chi| {
                let far = |dipole: &Dipole| reach2(tau, dipole, chi, displaced);
                dipoles.iter().map(far).fold(0.0, f64::max) as f32
            })
        })
        .collect();
    if params.projected == 0 {
        return;
    }
    data.cluster_reach = data
        .clusters
        .par_iter()
        .zip(&data.borders)
        .map(|(cluster, border)| {
            let far = |dipole: &Dipole| reach2(f64::from(cluster.moment_trace), dipole, chi[0], displaced);
            if border[1] > 0 { dipoles.iter().map(far).fold(0.0, f64::max) as f32 } else { 0.0 }
        })
        .collect();
}

/// Squared distance from a triangle's centroid beyond which chi stays below a threshold, for one channel.
///
/// `tau`: trace of the triangle's second moment. Radial sources lie `z` off the surface, which helps; displaced ones
/// may come nearer by `z_virtual`. Beyond a `sigma s` of [`FAINTEST`] the channel no longer counts.
pub fn reach2(tau: f64, dipole: &Dipole, chi: f64, displaced: bool) -> f64 {
    let sigma = dipole.sigma;
    if tau <= 0.0 {
        return if displaced { dipole.z_virtual.powi(2) } else { 0.0 };
    }
    let k = 2.0 * chi / tau - sigma * sigma;
    let mut s = if k > 0.0 { (5.0 * sigma + (25.0 * sigma * sigma + 60.0 * k).sqrt()) / (2.0 * k) } else { 1e9 };
    if sigma > 0.0 {
        s = s.min(FAINTEST / sigma);
    }
    if displaced { (s + dipole.z_virtual).powi(2) } else { (s * s - dipole.z_real * dipole.z_real).max(0.0) }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let displaced = u32::from(pass.state.distance == Distance::Table1);
    pass.dispatch(Some("face"), &[displaced], &[], pass.object().count.faces)?;
    if pass.state.method.projected {
        pass.dispatch(Some("cluster"), &[displaced], &[], pass.object().count.nodes)?;
    }
    Ok(())
}
