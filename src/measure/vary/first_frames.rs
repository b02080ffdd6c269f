//! What the pipeline cache saves: the time to make all pipelines of a scene, and its first two frames.

use std::time::Instant;

use super::Variant;
use crate::error::Result;
use crate::gpu::{Cache, Choices, Device, KernelKey, Kernels, Timing};
use crate::measure::profile::Settings;
use crate::measure::rounds::{Frame, Measured, Schedule, Starter, Variant as Timed, compare_each};
use crate::pipeline::plan::Change;
use crate::scene::Scene;
use crate::session::run::Session;

/// A variant that makes all pipelines anew in each round.
struct Start<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    open: &'a dyn Fn(&Choices) -> Result<Device>,
    choices: Choices,
    pipelines: &'a [KernelKey],
    /// What a file of the pipeline cache would hold.
    content: &'a [u8],
    /// A device that has made the pipelines before.
    warm: Option<Device>,
}

impl Timed for Start<'_> {
    fn frame(&mut self) -> Result<Frame> {
        let device = match &self.warm {
            Some(device) => device.forgetting_kernels(),
            None => (self.open)(&self.choices)?,
        };
        let begin = Instant::now();
        if self.choices.cache == Cache::Disk {
            device.renew_pipeline_cache(self.content)?;
        }
        let kernels = Kernels::new(&device);
        for key in self.pipelines {
            kernels.get(&key.name, &key.constants)?;
        }
        let made = begin.elapsed().as_secs_f64() * 1e3;
        let mut session = Session::new(self.scene, Some(&device), self.settings.options)?;
        let mut steps = vec![("pipelines", made)];
        for (name, change) in [("first frame", Change::EVERYTHING), ("second frame", self.settings.change)] {
            let begin = Instant::now();
            session.frame(change)?;
            steps.push((name, begin.elapsed().as_secs_f64() * 1e3));
        }
        let wall = steps.iter().map(|(_, milliseconds)| milliseconds).sum();
        let timing = |(name, milliseconds): (&str, f64)| Timing {
            name: name.into(),
            milliseconds,
            start: f64::NAN,
            ..Timing::default()
        };
        Ok(Frame { wall, steps: steps.into_iter().map(timing).collect(), ..Frame::default() })
    }
}

/// Times the making of all pipelines of a scene, and its first two frames, with the pipeline cache that each variant
/// starts from. A driver's own cache on disk is not switched off.
pub(super) fn compare_first_frames(
    scene: &Scene,
    variants: &[&Variant],
    open: &dyn Fn(&Choices) -> Result<Device>,
    settings: &Settings,
) -> Result<Measured> {
    let device = open(&Choices::default())?;
    let mut session = Session::new(scene, Some(&device), settings.options)?;
    session.frame(Change::EVERYTHING)?;
    session.frame(settings.change)?;
    let (pipelines, content) = (session.pipelines(), device.pipeline_cache_content()?);
    drop(session);
    let starter = |variant: &&Variant| {
        let (name, choices) = (variant.name.clone(), variant.choices.clone());
        let (pipelines, content) = (pipelines.as_slice(), content.as_slice());
        let warm = (choices.cache == Cache::Warm).then_some(&device);
        let start = move || {
            let (choices, warm) = (choices.clone(), warm.cloned());
            Ok(Box::new(Start { scene, settings, open, choices, pipelines, content, warm }) as _)
        };
        Starter { name, start: Box::new(start) }
    };
    let mut starters: Vec<Starter<'_>> = variants.iter().map(starter).collect();
    // A round is a start already.
    let rounds = settings.frames.min(MOST_ROUNDS);
    compare_each(&mut starters, &Schedule { rounds, ..settings.schedule() }, 1)
}

/// Most rounds, since each makes all pipelines of each variant.
const MOST_ROUNDS: usize = 24;
