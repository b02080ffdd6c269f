//! Diffusion as a transport: steps of its solver until the residual is as small as asked.

use super::run::Session;
use crate::error::Result;
use crate::gpu::Timing;
use crate::layout::{BufferId, ListCounters, SMALL_NORMS, SMALL_SYSTEM};
use crate::pipeline::plan::{Changes, Mode};
use crate::prepare::diffusion::residual;
use crate::state::{Scope, Step};
use crate::transport::diffusion::{boundary_integrals, even_gain, krylov_step, krylov_sum};

/// Starts of the solver, at most; each takes as many steps as its basis has room for.
const STARTS: usize = 20;

/// How a system of equations was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// The object.
    pub object: usize,
    /// Steps taken.
    pub steps: usize,
    /// Norm of the residual over that of the source term, in the mean over the area, per channel.
    pub residual: [f64; 3],
    /// Whether that is as small as asked.
    pub converged: bool,
}

/// Whether a step belongs to the solver's loop.
fn iterates(step: &Step) -> bool {
    step.stage.is(&boundary_integrals::STAGE) || step.stage.is(&krylov_step::STAGE)
}

/// The steps of a frame as a device gets them: lists that are submitted one after the other. The host waits for each
/// step of the solver.
#[cfg(feature = "measure")]
pub(crate) fn submitted(steps: &[Step]) -> Vec<Vec<Step>> {
    let Some(first) = steps.iter().position(iterates) else { return vec![steps.to_vec()] };
    let (before, after) = steps.split_at(first);
    let sums = |step: &&Step| step.stage.is(&krylov_sum::STAGE);
    let mut lists = vec![before.to_vec()];
    for sum in after.iter().filter(sums) {
        let iterations = |step: &&Step| iterates(step) && step.at.object == sum.at.object;
        let iterations: Vec<Step> = after.iter().filter(iterations).copied().collect();
        lists.extend(iterations.chunks(2).map(<[Step]>::to_vec));
        lists.push(vec![*sum]);
    }
    lists.push(after.iter().filter(|step| !iterates(step) && !sums(step)).copied().collect());
    lists
}

impl Session {
    /// Reports on the systems of the last frame that solved any, one for each translucent object.
    #[must_use]
    pub fn solve_reports(&self) -> &[SolveReport] {
        &self.solves
    }

    /// The steps of a frame after this change; of a solver, as many as it took in the last frame, if one start was
    /// enough.
    pub(crate) fn steps_taken(&self, changes: impl Into<Changes>) -> Vec<Step> {
        let mut steps = self.plan.steps(self.state(), changes);
        for SolveReport { object, steps: taken, .. } in &self.solves {
            let solver = |step: &Step| step.at.object == *object && iterates(step);
            if *taken < steps.iter().filter(|step| solver(step)).map(|step| step.at.chunk).max().unwrap_or(0) {
                steps.retain(|step| !solver(step) || step.at.chunk <= *taken);
                let sums =
                    steps.iter_mut().filter(|step| step.at.object == *object && step.stage.is(&krylov_sum::STAGE));
                sums.for_each(|step| step.at.chunk = *taken);
            }
        }
        steps
    }

    /// Runs these steps, those of the solver until it is done.
    pub(super) fn run_diffusion(&mut self, steps: &[Step]) -> Result<Vec<Timing>> {
        let Some(first) = steps.iter().position(iterates) else { return self.run(steps) };
        let mut times = self.run(&steps[..first])?;
        self.fetch(&[BufferId::counters])?;
        let ready = |counters: &ListCounters| counters.overflow == 0 && counters.unfinished == 0;
        if !self.state().data.counters.iter().all(ready) {
            return Ok(times);
        }
        let before = std::mem::take(&mut self.solves);
        let warms = matches!(self.plan.options().mode, Mode::Render | Mode::Incremental);
        for object in 0..self.state().objects.len() {
            let iterations: Vec<Step> =
                steps.iter().filter(|step| iterates(step) && step.at.object == object).copied().collect();
            if let Some(sum) = steps.iter().find(|step| step.stage.is(&krylov_sum::STAGE) && step.at.object == object) {
                self.solve_object(&iterations, *sum, warms && !before.is_empty(), &mut times)?;
            }
        }
        let rest: Vec<Step> = steps[first..]
            .iter()
            .filter(|step| !iterates(step) && !step.stage.is(&krylov_sum::STAGE))
            .copied()
            .collect();
        add(&mut times, self.run(&rest)?);
        Ok(times)
    }

    /// Solves the system of one object, `warm` from the last frame's solution.
    fn solve_object(&mut self, iterations: &[Step], sum: Step, warm: bool, times: &mut Vec<Timing>) -> Result<()> {
        let object = sum.at.object;
        let asked = self.scene.transport.steps;
        let target = self.targets(object);
        let mut report = SolveReport { object, ..SolveReport::default() };
        // Start from what is known: the last frame's solution, or what the starts before have found.
        self.prepared.state.method.warm = warm;
        for _ in 0..STARTS {
            let mut taken = 0;
            for pair in iterations.chunks(2) {
                add(times, self.run(pair)?);
                taken = pair[0].at.chunk;
                report.residual = self.residual_of(object)?;
                if taken == 0 && self.state().method.warm && !report.residual.iter().all(|&left| left <= 1.0) {
                    // A start that is worse than none, or NaN.
                    self.prepared.state.method.warm = false;
                    add(times, self.run(pair)?);
                    report.residual = self.residual_of(object)?;
                }
                report.converged = report.residual.iter().zip(target).all(|(&left, most)| left <= most);
                // A start that finds nothing left still takes a step.
                if report.converged && asked.is_none() && taken > 0 {
                    break;
                }
            }
            report.steps += taken;
            let at = Scope { chunk: taken, ..sum.at };
            add(times, self.run(&[Step { at, ..sum }])?);
            if report.converged || asked.is_some() {
                break;
            }
            self.prepared.state.method.warm = true;
        }
        self.prepared.state.method.warm = false;
        self.solves.push(report);
        Ok(())
    }

    /// The residuals at which an object's channels are done, by its area at rest.
    fn targets(&self, object: usize) -> [f64; 3] {
        let (mesh, length) = (&self.scene.objects[object].mesh, self.prepared.units.length);
        let corners = mesh.triangles.iter().map(|triangle| triangle.map(|v| mesh.positions[v as usize]));
        let area: f64 = corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        let gains = even_gain(&self.state().data.object_params[object], area * length * length);
        gains.map(|gain| residual(self.scene.transport.tolerance, gain))
    }

    /// The norm of the residual over that of the source term, per channel; where there is no source, 0 or infinite.
    fn residual_of(&mut self, object: usize) -> Result<[f64; 3]> {
        self.fetch(&[BufferId::small_system])?;
        let small = &self.state().data.small_system[object * SMALL_SYSTEM..];
        let [whole, left] = [SMALL_NORMS, SMALL_NORMS + 1].map(|place| small[place].map(f64::from));
        Ok(std::array::from_fn(|c| if left[c] == 0.0 { 0.0 } else { left[c] / whole[c] }))
    }
}

/// Adds times to those of the same stage.
fn add(times: &mut Vec<Timing>, more: Vec<Timing>) {
    let end = times.last().map_or(0.0, |last| last.start + last.milliseconds);
    for time in more {
        match times.iter_mut().find(|known| known.name == time.name) {
            Some(known) => {
                known.milliseconds += time.milliseconds;
                known.dispatches += time.dispatches;
                known.barriers += time.barriers;
            }
            None => times.push(Timing { start: end + time.start, ..time }),
        }
    }
}
