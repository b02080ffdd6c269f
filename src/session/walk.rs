//! The random walk as a transport: rounds of flights until the noise is as small as asked, and what became of the
//! light.

use super::patches::patches;
use super::run::Session;
use super::walk_control::{Course, End};
pub use super::walk_control::{WalkControl, WalkProgress};
pub use super::walk_report::WalkReport;
use super::walk_report::report_of;
use crate::error::Result;
use crate::gpu::Timing;
use crate::layout::{BufferId, WalkParams};
use crate::pipeline::plan::ShadingMethod;
use crate::prepare::diffusion_validity::enclosed;
use crate::prepare::scene::Prepared;
use crate::prepare::units::Units;
use crate::scene::{Material, Scene};
use crate::state::{State, Step};
use crate::transport::walk::{blocks, random_walk};

/// Photons under way at once, of each channel.
const SLOTS: u32 = 8192;
/// Photons of each channel from which the number needed is estimated.
const PILOT: u32 = 8192;
/// Extinction at most, per internal length: denser materials are scaled down to it, with their albedo kept, because
/// positions in `f32` would show no walk.
const WALK_DENSEST: f64 = 1e5;

/// The walks of a session.
#[derive(Default)]
pub struct WalkTransport {
    /// How the walks are watched.
    pub control: WalkControl,
    /// What became of the light in the last frame's walk, of each translucent object.
    pub reports: Vec<WalkReport>,
    /// Light that enters in the place of irradiance, in the order and the units of the buffer.
    pub entering: Option<Vec<[f32; 3]>>,
}

/// How light walks through a material.
fn params(material: &Material, units: Units, object: usize, slots: u32, photons: u32) -> WalkParams {
    let mut params = WalkParams { photons, slots: 3 * slots, seed: 1 + object as u32, ..WalkParams::default() };
    if material.opaque.is_some() {
        return params;
    }
    for c in 0..3 {
        let scattering = material.sigma_s_prime[c] / (1.0 - material.g[c]);
        let extinction = scattering + material.sigma_a[c];
        params.free_path[c] = (units.length / extinction).clamp(1.0 / WALK_DENSEST, 1e6) as f32;
        params.forward[c] = material.g[c] as f32;
        params.absorbed[c] = (material.sigma_a[c] / extinction * f64::exp2(32.0)).round() as u32;
    }
    params
}

/// Sets the parameters of all objects' walks; an error where a walk has no meaning.
pub(super) fn prepare_walk(prepared: &mut Prepared, scene: &Scene, control: WalkControl) -> Result<()> {
    let asked = scene.transport.walks;
    let inside = "light can only walk through a closed object";
    enclosed(&scene.objects, "walk", [inside, "light enters a walk from outside only"])?;
    let slots = asked.unwrap_or(SLOTS).min(SLOTS);
    // Where a limit or a listener needs to know how long all photons take, the first ones tell.
    let watched = control.limit.is_some() || control.tell.is_some();
    let photons = match asked.filter(|_| control.within.is_none()) {
        Some(asked) if !watched => asked,
        Some(asked) => asked.min(PILOT),
        None => PILOT,
    };
    let params_of = |(number, object): (usize, &crate::scene::Object)| {
        let params = params(&object.material, prepared.units, number, slots, photons);
        WalkParams { seed: params.seed.wrapping_add(control.seed), ..params }
    };
    prepared.state.data.walk_params = scene.objects.iter().enumerate().map(params_of).collect();
    Ok(())
}

impl Session {
    /// Whether a random walk is the transport.
    pub(super) fn walks(&self) -> bool {
        self.plan.options().transport == ShadingMethod::Walk
    }

    /// How walks are watched from the next frame on.
    pub fn watch_walk(&mut self, control: WalkControl) {
        self.walk.control = control;
    }

    /// Has this much light enter each triangle from the next frame on, in the place of its irradiance, whose directions
    /// it keeps: E in the scene's units, object after object, in the order of the meshes.
    pub fn walk_from(&mut self, light: &[[f64; 3]]) {
        let (mut entering, mut light) = (vec![[0.0; 3]; self.state().data.irradiance.len()], light.iter());
        for object in 0..self.scene.objects.len() {
            for (place, e) in self.prepared.places(object).into_iter().zip(&mut light) {
                entering[place] = e.map(|e| (e / self.prepared.units.light) as f32);
            }
        }
        self.walk.entering = Some(entering);
    }

    /// A line for the user if walks rely on a rounding that the device does not promise.
    #[must_use]
    pub fn walk_caveat(&self) -> Option<String> {
        let device = self.device().filter(|device| self.walks() && !device.limits().round_to_nearest)?;
        let what = "rounding to nearest can't be requested; its walks may not be those of the CPU, photon by photon";
        Some(format!("{}: {what}", device.name()))
    }

    /// What became of the light in the last frame's walk.
    #[must_use]
    pub fn walk_reports(&self) -> &[WalkReport] {
        &self.walk.reports
    }

    /// Runs these steps, those of a walk as often as it takes.
    pub(super) fn run_walk(&mut self, steps: &[Step]) -> Result<Vec<Timing>> {
        let is_walk = |step: &Step| step.stage.is(&random_walk::STAGE);
        let (mut times, mut rest) = (Vec::new(), steps);
        if steps.iter().any(is_walk) {
            self.walk.reports.clear();
            prepare_walk(&mut self.prepared, &self.scene, self.walk.control)?;
            self.send(&[BufferId::walk_params])?;
        }
        if let Some(light) = self.walk.entering.clone() {
            let of_walk = |step: &Step| step.stage.module == random_walk::STAGE.module;
            let first = steps.iter().position(of_walk).unwrap_or(steps.len());
            times.extend(self.run(&steps[..first])?);
            self.prepared.state.data.irradiance = light;
            self.send(&[BufferId::irradiance])?;
            rest = &steps[first..];
        }
        while let Some(at) = rest.iter().position(is_walk) {
            times.extend(self.run(&rest[..at])?);
            let start = times.last().map_or(0.0, |time: &Timing| time.start + time.milliseconds);
            let seconds = self.walk_object(rest[at])?;
            times.push(Timing {
                name: random_walk::STAGE.name.into(),
                milliseconds: 1e3 * seconds,
                start,
                ..Timing::default()
            });
            rest = &rest[at + 1..];
        }
        times.extend(self.run(rest)?);
        Ok(times)
    }

    /// Walks through one object; returns the seconds that it took.
    fn walk_object(&mut self, step: Step) -> Result<f64> {
        let (object, control, transport) = (step.at.object, self.walk.control, &self.scene.transport);
        let end = match (control.within, transport.walks) {
            (Some(time), _) => End::Within(time),
            (None, Some(photons)) => End::Photons(photons),
            (None, None) => End::Noise(transport.walk_error),
        };
        let mut course = Course::new(object, end, control)?;
        self.fetch(&[BufferId::clusters, BufferId::entry_blocks])?;
        let parts = patches(self.state(), object);
        loop {
            let stopped = self.finish(step, &mut course)?;
            self.fetch(&[BufferId::exits, BufferId::balances])?;
            let mut report = report_of(self.state(), object, &parts)?;
            (report.seconds, report.stopped) = (course.begin.elapsed().as_secs_f64(), stopped);
            course.learn(report.photons, report.noise.into_iter().fold(0.0, f64::max));
            let (photons, needed) = (f64::from(report.photons), course.needed().unwrap_or(0.0));
            let next = match end {
                End::Photons(photons) => photons,
                // Somewhat more, and not too many where the noise is not yet well known.
                _ => (1.05 * needed).min(64.0 * photons).min(f64::from(crate::scene::MOST_WALKS)) as u32,
            };
            if stopped || needed <= photons || next <= report.photons {
                let seconds = report.seconds;
                self.walk.reports.push(report);
                return Ok(seconds);
            }
            course.go_on(report.photons);
            self.prepared.state.data.walk_params[object].photons = next;
            self.send(&[BufferId::walk_params])?;
        }
    }

    /// Runs rounds until no photon is under way; returns whether it was stopped before all have started.
    fn finish(&mut self, step: Step, course: &mut Course) -> Result<bool> {
        let mut stopped = false;
        loop {
            self.run(&[step])?;
            self.fetch(&[BufferId::photons])?;
            let data = &self.state().data;
            let (params, light) = (data.walk_params[step.at.object], lit_channels(self.state(), step.at.object));
            let every = params.slots / 3;
            let number = |slot: usize| slot as u32 / 3 + data.photons[slot].started * every;
            let slots = || (0..params.slots as usize).filter(|slot| light[slot % 3]);
            if slots().all(|slot| data.photons[slot].weight == 0 && number(slot) >= params.photons) {
                return Ok(stopped);
            }
            let started: f64 = slots().map(|slot| f64::from(data.photons[slot].started)).sum();
            let started = started / light.iter().filter(|lit| **lit).count().max(1) as f64;
            course.show(started);
            course.foretell(started)?;
            course.bounded()?;
            if !stopped && course.over() {
                // Every slot starts as many as the one that has started most.
                let most = slots().map(|slot| data.photons[slot].started).max().unwrap_or(0);
                stopped = most * every < params.photons;
                self.prepared.state.data.walk_params[step.at.object].photons = params.photons.min(most * every);
                self.send(&[BufferId::walk_params])?;
            }
        }
    }
}

/// Whether light enters an object, per channel.
fn lit_channels(state: &State, object: usize) -> [bool; 3] {
    let total = &state.data.entry_blocks[blocks(state.objects[object].count.faces)];
    [0, 1, 2].map(|c| total.sum(c) > 0)
}
