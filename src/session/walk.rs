//! The random walk as a transport: rounds of flights until the noise is as small as asked, and what became of the
//! light.

use std::time::{Duration, Instant};

use super::patches::patches;
use super::run::Session;
use crate::error::{Error, Input, Result};
use crate::gpu::Timing;
use crate::layout::{BufferId, WALK_WEIGHT, WalkBalance, WalkParams};
use crate::pipeline::plan::ShadingMethod;
use crate::prepare::scene::Prepared;
use crate::prepare::units::Units;
use crate::scene::{Material, Scene};
use crate::state::{State, Step};
use crate::transport::walk::{blocks, random_walk, sum64};

/// Photons under way at once, of each channel.
const SLOTS: u32 = 8192;
/// Photons of each channel from which the number needed is estimated.
const PILOT: u32 = 8192;
/// Extinction at most, per internal length: denser materials are scaled down to it, with their albedo kept, because
/// positions in `f32` would show no walk.
const WALK_DENSEST: f64 = 1e5;
/// Share of the light that may find no way out, by rounding.
const LOST: f64 = 1e-4;
/// Photons that may be lost however few there are.
const FEW_LOST: u64 = 8;
/// Seconds from which a walk says how long it takes.
const LONG: f64 = 10.0;

/// How a session's walks are watched.
#[derive(Clone, Copy, Default)]
pub struct WalkControl {
    /// The longest that a walk may take: one that will take longer is refused once that is known.
    pub limit: Option<Duration>,
    /// The time after which it ends with what there is, for each object.
    pub within: Option<Duration>,
    /// Asked between rounds whether to end with what there is.
    pub stop: Option<fn() -> bool>,
    /// Told how long a walk takes.
    pub tell: Option<fn(&str)>,
}

/// The walks of a session.
#[derive(Default)]
pub struct WalkTransport {
    /// How they are watched.
    pub control: WalkControl,
    /// What became of the light in the last frame's walk, of each translucent object.
    pub reports: Vec<WalkReport>,
}

/// What became of the light in a walk through an object, per channel; shares are of what entered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WalkReport {
    /// The object.
    pub object: usize,
    /// Photons of each channel.
    pub photons: u32,
    /// Time of the walk, seconds.
    pub seconds: f64,
    /// Estimated relative error of the radiosity's means over patches, L2.
    pub noise: [f64; 3],
    /// Share that left after a collision.
    pub left: [f64; 3],
    /// Share that left without one: it is not in the radiosity.
    pub straight: [f64; 3],
    /// Share that was absorbed.
    pub absorbed: [f64; 3],
    /// Share that found no way out.
    pub lost: [f64; 3],
    /// Whether it was stopped before it was as exact as asked.
    pub stopped: bool,
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
pub(super) fn prepare_walk(prepared: &mut Prepared, scene: &Scene) -> Result<()> {
    let asked = scene.transport.walks;
    for (number, object) in scene.objects.iter().enumerate().filter(|(_, object)| object.material.opaque.is_none()) {
        let fault = |what: &str| Input::new(what).key(format!("object.{number}"));
        if object.mesh.open_edges > 0 {
            let found = format!("{} open edges", object.mesh.open_edges);
            let fault = fault("light can only walk through a closed object").found(found);
            return Err(fault.expected("a closed mesh, or another --transport than walk").into());
        }
        if object.material.two_sided {
            let fault = fault("light enters a walk from outside only").found("two_sided = true");
            return Err(fault.expected("two_sided = false, or another --transport than walk").into());
        }
    }
    let (slots, photons) = (asked.unwrap_or(SLOTS).min(SLOTS), asked.unwrap_or(PILOT));
    let of = |(number, object): (usize, &crate::scene::Object)| {
        params(&object.material, prepared.units, number, slots, photons)
    };
    prepared.state.data.walk_params = scene.objects.iter().enumerate().map(of).collect();
    Ok(())
}

/// Sum of a balance over the slots of a channel.
fn sum(state: &State, channel: usize, of: fn(&WalkBalance) -> [u32; 2]) -> u64 {
    state.data.balances.iter().skip(channel).step_by(3).map(|balance| sum64(of(balance))).sum()
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

    /// What became of the light in the last frame's walk.
    #[must_use]
    pub fn walk_reports(&self) -> &[WalkReport] {
        &self.walk.reports
    }

    /// Runs these steps, those of a walk as often as it takes.
    pub(super) fn run_walk(&mut self, steps: &[Step]) -> Result<Vec<Timing>> {
        let is_walk = |step: &Step| step.stage.is(&random_walk::STAGE);
        if steps.iter().any(is_walk) {
            self.walk.reports.clear();
            prepare_walk(&mut self.prepared, &self.scene)?;
            self.send(&[BufferId::walk_params])?;
        }
        let (mut times, mut rest) = (Vec::new(), steps);
        while let Some(at) = rest.iter().position(is_walk) {
            times.extend(self.run(&rest[..at])?);
            let start = times.last().map_or(0.0, |time: &Timing| time.start + time.milliseconds);
            let seconds = self.walk_object(rest[at])?;
            times.push(Timing { name: random_walk::STAGE.name.into(), milliseconds: 1e3 * seconds, start });
            rest = &rest[at + 1..];
        }
        times.extend(self.run(rest)?);
        Ok(times)
    }

    /// Walks through one object; returns the seconds that it took.
    fn walk_object(&mut self, step: Step) -> Result<f64> {
        let (object, begin, control) = (step.at.object, Instant::now(), self.walk.control);
        self.fetch(&[BufferId::clusters, BufferId::entry_blocks])?;
        let parts = patches(self.state(), object);
        let target = self.scene.transport.walk_error;
        let mut told = false;
        loop {
            let stopped = self.finish(step, control.within.map(|time| begin + time))?;
            self.fetch(&[BufferId::exits, BufferId::balances])?;
            let mut report = self.report(object, &parts)?;
            (report.seconds, report.stopped) = (begin.elapsed().as_secs_f64(), stopped);
            let worst = report.noise.into_iter().fold(0.0, f64::max);
            let photons = f64::from(report.photons);
            let needed = photons * (worst / target).powi(2);
            if stopped || self.scene.transport.walks.is_some() || needed <= photons {
                let seconds = report.seconds;
                self.walk.reports.push(report);
                return Ok(seconds);
            }
            let expected = report.seconds * needed / photons;
            let about = format!("about {needed:.1e} photons a channel, {expected:.0} s");
            if let Some(limit) = control.limit.filter(|limit| expected > limit.as_secs_f64()) {
                let fault = Input::new(format!("a walk to transport.walk_error = {target} takes {about}"));
                let expected = format!("at most {:.0} s: a larger walk_error, or --limit-time", limit.as_secs_f64());
                return Err(fault.key("--limit-time").found(format!("{expected:.0} s")).expected(expected).into());
            }
            if let Some(tell) = control.tell.filter(|_| !told && expected > LONG) {
                tell(&format!("long: object {object} takes {about}; Ctrl-C ends with what there is"));
                told = true;
            }
            let next = (1.05 * needed).min(64.0 * photons).min(f64::from(crate::scene::MOST_WALKS)) as u32;
            if next <= report.photons {
                self.walk.reports.push(report);
                return Ok(begin.elapsed().as_secs_f64());
            }
            self.prepared.state.data.walk_params[object].photons = next;
            self.send(&[BufferId::walk_params])?;
        }
    }

    /// Runs rounds until no photon is under way; returns whether it was stopped before all have started.
    fn finish(&mut self, step: Step, end: Option<Instant>) -> Result<bool> {
        let mut stopped = false;
        let over = |stop: Option<fn() -> bool>| {
            stop.is_some_and(|stop| stop()) || end.is_some_and(|end| Instant::now() >= end)
        };
        loop {
            self.run(&[step])?;
            self.fetch(&[BufferId::photons])?;
            let data = &self.state().data;
            let (params, light) = (data.walk_params[step.at.object], total_of(self.state(), step.at.object));
            let every = params.slots / 3;
            let number = |slot: usize| slot as u32 / 3 + data.photons[slot].started * every;
            let slots = || (0..params.slots as usize).filter(|slot| light[slot % 3]);
            if slots().all(|slot| data.photons[slot].weight == 0 && number(slot) >= params.photons) {
                return Ok(stopped);
            }
            if !stopped && over(self.walk.control.stop) {
                // Every slot starts as many as the one that has started most.
                let most = slots().map(|slot| data.photons[slot].started).max().unwrap_or(0);
                stopped = most * every < params.photons;
                self.prepared.state.data.walk_params[step.at.object].photons = params.photons.min(most * every);
                self.send(&[BufferId::walk_params])?;
            }
        }
    }

    /// What became of the light so far; an error where it does not add up, or does not find out.
    fn report(&self, object: usize, parts: &[std::ops::Range<usize>]) -> Result<WalkReport> {
        let state = self.state();
        let (own, data) = (&state.objects[object], &state.data);
        let exits = &data.exits[own.first.faces..][..own.count.faces];
        let photons = data.walk_params[object].photons;
        let mut report = WalkReport { object, photons, ..WalkReport::default() };
        for c in 0..3 {
            let of = |of: fn(&WalkBalance) -> [u32; 2]| sum(state, c, of);
            let left: u64 = exits.iter().map(|exit| exit.once(c) + exit.more(c)).sum();
            let (entered, gained, killed) = (of(|b| b.entered), of(|b| b.gained), of(|b| b.killed));
            let (straight, absorbed, lost) = (of(|b| b.straight), of(|b| b.absorbed), of(|b| b.lost));
            if entered + gained != left + straight + absorbed + lost + killed {
                let what = format!("{entered} + {gained} in, {left} + {straight} + {absorbed} + {lost} + {killed} out");
                return Err(Error::device("adding up the light of a walk", what));
            }
            let share = |weight: u64| if entered > 0 { weight as f64 / entered as f64 } else { 0.0 };
            (report.left[c], report.straight[c]) = (share(left), share(straight));
            (report.absorbed[c], report.lost[c]) = (share(absorbed), share(lost));
            if lost > FEW_LOST * u64::from(WALK_WEIGHT) && report.lost[c] > LOST {
                let photons = lost.div_ceil(WALK_WEIGHT.into());
                let found = format!("{photons} photons, {:.2e} of the light, that found no way out", report.lost[c]);
                let fault = Input::new("the surface has holes or crosses itself").key(format!("object.{object}"));
                return Err(fault.found(found).expected("a closed mesh that does not cross itself").into());
            }
            let (mut noise, mut square) = (0.0, 0.0);
            for faces in parts {
                let area =
                    |face: usize| data.clusters[own.first.nodes + data.leaves[own.first.faces + face] as usize].area;
                let area: f64 = faces.clone().map(|face| f64::from(area(face))).sum();
                let [left, squares] = exits[faces.clone()]
                    .iter()
                    .map(|exit| exit.moments(c))
                    .fold([0.0; 2], |[left, squares], [one, two]| [left + one, squares + two]);
                let variance = (squares - left * left / f64::from(photons.max(1))).max(0.0);
                if area > 0.0 {
                    noise += variance / area;
                    square += (left * left - variance).max(0.0) / area;
                }
            }
            report.noise[c] = if square > 0.0 {
                (noise / square).sqrt()
            } else if noise > 0.0 {
                1.0
            } else {
                0.0
            };
        }
        Ok(report)
    }
}

/// Whether light enters an object, per channel.
fn total_of(state: &State, object: usize) -> [bool; 3] {
    let total = &state.data.entry_blocks[blocks(state.objects[object].count.faces)];
    [0, 1, 2].map(|c| total.sum(c) > 0)
}
