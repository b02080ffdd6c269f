//! Diffusion in extreme media and shapes: the device's radiosity against the CPU's, and the residual of the equation at
//! some triangles, by sums over all triangles in `f64`.

use super::{Found, Plant, Worst};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::norms::worst;
use crate::measure::reference::verify;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::run::Session;

/// A solved session.
fn solved(scene: &Scene, device: Option<&Device>) -> Result<Session> {
    let options = Options { transport: ShadingMethod::Diffusion, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    session.fetch(&[BufferId::radiosity, BufferId::solution])?;
    Ok(session)
}

/// The radiosity against the CPU's, and the residual of the equation.
pub(super) fn run(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    let (expected, mut found) = (solved(scene, None)?, solved(scene, device)?);
    let mut radiosity = found.state().data.radiosity.clone();
    if let Some(plant) = plant {
        plant.apply(&mut radiosity);
    }
    let (mut usual, mut left) = (Found::default(), Found::default());
    usual.look("radiosity", &radiosity);
    for channel in 0..3 {
        let pairs = || expected.state().data.radiosity.iter().zip(&radiosity).map(|(a, b)| (a[channel], b[channel]));
        if pairs().all(|(expected, _)| expected == 0.0) {
            usual.faults.push(format!("no light leaves in channel {channel}"));
        }
        let own = Worst::of(pairs(), radiosity.len());
        // NaN counts as more than any number.
        let worse = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        usual.error = Worst { l2: worse(own.l2, usual.error.l2), max: worse(own.max, usual.error.max) };
    }
    for report in found.solve_reports().iter().filter(|report| !report.converged) {
        left.faults.push(format!("not solved after {} steps: {:?} is left", report.steps, report.residual));
    }
    left.error = worst(&verify(&mut found, 60, 1)?).into();
    Ok([usual, left])
}
