//! What drafts leave out, so that a frame stays short. The rule: a draft's time is predicted from the time that each
//! stage took when it ran last, and the finest draft is made that is predicted to take at most [`AIM`].

use milkglass::internals::gpu::Timing;
use milkglass::internals::lighting::shadow;
use milkglass::internals::pipeline::frame::stage;
use milkglass::internals::state::{Granularity, Need, Stage};
use milkglass::internals::view::pixel_receivers;
use milkglass::scene::{Light, Receivers, Scene, Source};

use super::history::stage_of;

/// The longest predicted time of a draft, ms: the actual time varies, and the window has to be drawn, too.
const AIM: f64 = 170.0;
/// The share of [`AIM`] that a finer draft than the last one may be predicted to take, so that drafts do not alternate.
const FINER: f64 = 0.8;
/// The tolerance of drafts, if the scene's is not coarser.
const TOLERANCE: f64 = 0.1;
/// Pixels of the window along each side of a draft's pixel.
pub(super) const FACTORS: [u32; 6] = [1, 2, 3, 4, 6, 8];

/// What a draft leaves out, whatever its resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// Rays to the sky from a face, at most.
    sky: u32,
    /// Samples along each side of an area light, at most.
    area: u32,
    /// Whether there are shadows.
    shadows: bool,
    /// Whether light is transported through objects.
    pub(super) transport: bool,
}

/// From the finest to the coarsest.
pub(super) const LEVELS: [Level; 4] = [
    Level { sky: 4, area: 2, shadows: true, transport: true },
    Level { sky: 1, area: 1, shadows: true, transport: true },
    Level { sky: 0, area: 1, shadows: false, transport: true },
    Level { sky: 0, area: 1, shadows: false, transport: false },
];

impl Level {
    /// The scene as a draft shows it; its camera is left alone.
    pub(super) fn of(&self, scene: &Scene) -> Scene {
        let mut coarse = scene.clone();
        coarse.camera.samples = 1;
        coarse.transport.tolerance = coarse.transport.tolerance.max(TOLERANCE);
        coarse.transport.subdivide = 0;
        // With pixels as receivers, each size of a picture has buffers of its own, and each view links of its own.
        coarse.transport.receivers = Receivers::Faces;
        for light in &mut coarse.lights {
            light.shadows &= self.shadows;
            match &mut light.source {
                Source::Environment { occlusion, .. } => *occlusion = self.sky.min(*occlusion),
                Source::Area { samples, .. } => *samples = self.area.min(*samples),
                _ => {}
            }
        }
        coarse
    }

    /// Rays of a face to the lights of a scene.
    fn rays(&self, scene: &Scene) -> f64 {
        let rays = |light: &Light| match light.source {
            Source::Environment { occlusion, .. } => self.sky.min(occlusion),
            _ if !(light.shadows && self.shadows) => 0,
            Source::Area { samples, .. } => self.area.min(samples).pow(2),
            _ => 1,
        };
        f64::from(scene.lights.iter().map(rays).sum::<u32>())
    }
}

/// Chooses drafts.
#[derive(Clone, Debug)]
pub(super) struct Policy {
    /// The time of each stage that does not depend on a draft's pixels, ms; that of `shadow` for one ray of a face.
    stages: Vec<(String, f64)>,
    /// The time of each stage that does, ms, scaled to all pixels of the window: with transport, and without.
    picture: [Vec<(String, f64)>; 2],
    /// The draft: its index in [`LEVELS`], and its index in [`FACTORS`].
    pub(super) level: usize,
    pub(super) coarseness: usize,
    /// The coarsest level that can serve the scene.
    pub(super) coarsest: usize,
}

impl Default for Policy {
    fn default() -> Self {
        let coarsest = LEVELS.len() - 1;
        Self { stages: Vec::new(), picture: Default::default(), level: 0, coarseness: 3, coarsest }
    }
}

impl Policy {
    /// Adopts the times of a draft: of its steps on the device, and `all` of it, ms.
    pub(super) fn learn(&mut self, scene: &Scene, steps: &[Timing], all: f64) {
        let (stages, picture) = costs(steps, all, LEVELS[self.level].rays(scene));
        let own = usize::from(!LEVELS[self.level].transport);
        adopt(&mut self.stages, stages, 1.0);
        adopt(&mut self.picture[own], picture, f64::from(FACTORS[self.coarseness].pow(2)));
    }

    /// Whether it has adopted anything.
    pub(super) fn knows(&self) -> bool {
        !self.stages.is_empty() || self.picture.iter().any(|stages| !stages.is_empty())
    }

    /// Adopts the times of a whole frame where they are less: it does no less than a draft.
    pub(super) fn relearn(&mut self, scene: &Scene, steps: &[Timing], all: f64) {
        let rays = scene.lights.iter().filter(|light| light.shadows).map(Light::samples).sum::<usize>();
        for (name, cost) in costs(steps, all, rays as f64).0 {
            if let Some((_, before)) = self.stages.iter_mut().find(|(stage, _)| *stage == name) {
                *before = before.min(cost);
            }
        }
    }

    /// Chooses the next draft of a scene; the stages before the picture run only if `all` is to be done. `spent` ms
    /// went to the change itself.
    pub(super) fn choose(&mut self, scene: &Scene, all: bool, spent: f64) {
        if !self.knows() {
            return;
        }
        let budget = |finer: bool| if finer { AIM * FINER - spent } else { AIM - spent };
        if all {
            let least = |level: usize| self.picture(level, FACTORS.len() - 1);
            let fits = |level: &usize| self.predicted(scene, *level) + least(*level) <= budget(*level < self.level);
            // At most one step finer: how long that takes is measured first.
            self.level = (self.level.saturating_sub(1)..self.coarsest).find(fits).unwrap_or(self.coarsest);
        }
        let rest = if all { self.predicted(scene, self.level) } else { 0.0 };
        let picture = |coarseness: usize| self.picture(self.level, coarseness);
        let fits = |coarseness: &usize| rest + picture(*coarseness) <= budget(*coarseness < self.coarseness);
        self.coarseness = (0..FACTORS.len()).find(fits).unwrap_or(FACTORS.len() - 1);
    }

    /// The predicted time of a draft's picture, ms.
    fn picture(&self, level: usize, coarseness: usize) -> f64 {
        let own = usize::from(!LEVELS[level].transport);
        let known = if self.picture[own].is_empty() { &self.picture[1 - own] } else { &self.picture[own] };
        known.iter().map(|(_, cost)| cost).sum::<f64>() / f64::from(FACTORS[coarseness].pow(2))
    }

    /// The predicted time of a draft without its picture, ms.
    fn predicted(&self, scene: &Scene, level: usize) -> f64 {
        let level = &LEVELS[level];
        let cost = |(name, cost): &(String, f64)| match stage(name) {
            Some(known) if known.is(&shadow::STAGE) => cost * level.rays(scene),
            Some(known) if known.module.starts_with("transport") && !level.transport => 0.0,
            _ => *cost,
        };
        self.stages.iter().map(cost).sum()
    }
}

/// Costs of stages, by their names.
type Costs = Vec<(String, f64)>;

/// Puts new costs, times a factor, in the place of known ones.
fn adopt(known: &mut Costs, new: Costs, factor: f64) {
    for (name, cost) in new {
        match known.iter_mut().find(|(stage, _)| *stage == name) {
            Some((_, before)) => *before = cost * factor,
            None => known.push((name, cost * factor)),
        }
    }
}

/// The time of each stage that does not depend on the pixels, ms, then of each stage that does; that of `shadow` is for
/// one of `rays`. The part of `all` that no step has goes to the first one: with a window, lavapipe starts the clock of
/// a frame too late.
fn costs(steps: &[Timing], all: f64, rays: f64) -> (Costs, Costs) {
    let mut of_picture = false;
    let (mut sums, mut picture): (Costs, Costs) = Default::default();
    let mut late = all - steps.iter().map(|step| step.milliseconds).filter(|ms| ms.is_finite()).sum::<f64>();
    for step in steps.iter().filter(|step| step.milliseconds.is_finite()) {
        let name = stage_of(step);
        // Where pixels are the receivers, so are all stages after this one.
        of_picture |= name == pixel_receivers::STAGE.name;
        let milliseconds = step.milliseconds + std::mem::take(&mut late).max(0.0);
        let cost = milliseconds / if name == shadow::STAGE.name { rays.max(1.0) } else { 1.0 };
        // Other stages that only pictures need run for each object, whatever the number of pixels.
        let pixels = |stage: &Stage| stage.needs.contains(&Need::Picture) && stage.granularity == Granularity::Scene;
        let list = if of_picture || stage(name).is_some_and(pixels) { &mut picture } else { &mut sums };
        match list.iter_mut().find(|(stage, _)| stage == name) {
            Some((_, sum)) => *sum += cost,
            None => list.push((name.to_owned(), cost)),
        }
    }
    (sums, picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::internals::geometry::refit;
    use milkglass::internals::transport::blocks::link;
    use milkglass::internals::view::visibility;

    fn step(name: &str, milliseconds: f64) -> Timing {
        Timing { name: name.into(), milliseconds, ..Timing::default() }
    }

    /// The level and the factor that drafts settle at. The times, in ms, are those of one ray of each face, of the
    /// other stages before the picture, and of the picture at the window's pixels.
    fn settled(scene: &Scene, [ray, others, picture]: [f64; 3], all: bool) -> (usize, u32) {
        let mut policy = Policy::default();
        for _ in 0..10 {
            let level = &LEVELS[policy.level];
            let transport = if level.transport { others } else { 0.0 };
            let picture = picture / f64::from(FACTORS[policy.coarseness].pow(2));
            let mut steps = vec![step(visibility::STAGE.name, picture)];
            if all {
                let all = [(shadow::STAGE.name, ray * level.rays(scene)), (link::STAGE.name, transport)];
                // A stage that a draft leaves out is no step of it.
                steps.extend(all.into_iter().filter(|(_, ms)| *ms > 0.0).map(|(name, ms)| step(name, ms)));
            }
            let sum: f64 = steps.iter().map(|step| step.milliseconds).sum();
            policy.learn(scene, &steps, sum + 5.0);
            policy.choose(scene, all, 0.0);
        }
        (policy.level, FACTORS[policy.coarseness])
    }

    #[test]
    fn drafts_are_as_fine_as_the_time_allows() {
        // A sky and a sun: at the finest level five rays of a face.
        let scene = Scene::load("bust").unwrap();
        let rays = LEVELS.map(|level| level.rays(&scene));
        assert!(rays[0] > rays[1] && rays[1] > 0.0 && rays[2] == 0.0, "{rays:?}");
        assert_eq!(settled(&scene, [1.0, 10.0, 50.0], true), (0, 1));
        assert_eq!(settled(&scene, [1.0, 10.0, 1000.0], true), (0, 3));
        assert_eq!(settled(&scene, [130.0 / rays[1], 10.0, 50.0], true).0, 1);
        assert_eq!(settled(&scene, [300.0, 50.0, 50.0], true).0, 2);
        assert_eq!(settled(&scene, [300.0, 500.0, 50.0], true), (3, 1));
        assert_eq!(settled(&scene, [300.0, 500.0, 1e6], true), (3, 8));
        // A camera alone: only the picture counts.
        assert_eq!(settled(&scene, [300.0, 500.0, 400.0], false), (0, 2));
    }

    #[test]
    fn drafts_get_finer_again_when_a_whole_frame_was_fast() {
        let scene = Scene::load("lotus").unwrap();
        let mut policy = Policy::default();
        policy.learn(&scene, &[step(link::STAGE.name, 900.0), step(refit::STAGE.name, 10.0)], 920.0);
        policy.choose(&scene, true, 0.0);
        assert_eq!(policy.level, 3);
        policy.relearn(&scene, &[step(link::STAGE.name, 50.0), step(refit::STAGE.name, 20.0)], 70.0);
        for level in [2, 1, 0] {
            policy.choose(&scene, true, 0.0);
            assert_eq!(policy.level, level, "one step at a time");
        }
        policy.choose(&scene, true, 150.0);
        assert_eq!(policy.level, 3, "the change itself took most of the time");
    }

    #[test]
    fn where_pixels_are_the_receivers_all_that_follows_is_of_the_picture() {
        let (fixed, receivers) = (refit::STAGE.name, pixel_receivers::STAGE.name);
        let steps = [step(fixed, 10.0), step(visibility::STAGE.name, 20.0), step(receivers, 1.0), step(fixed, 5.0)];
        for (all, first) in [(36.0, 10.0), (40.0, 14.0)] {
            let (before, picture) = costs(&steps, all, 1.0);
            assert_eq!(before, [(fixed.to_owned(), first)]);
            assert_eq!(picture.iter().map(|(_, ms)| ms).sum::<f64>(), 26.0);
        }
    }
}
