//! A scene on a device: each variant of an axis is proved, then all are timed in turn with the default.

use super::first_frames::compare_first_frames;
use super::proof::{Computed, Proof, computed, proof};
use super::{Asked, Variant, lack};
use crate::error::Result;
use crate::gpu::{Cache, Choices, Device};
use crate::measure::fixtures::Fixture;
use crate::measure::profile::{Settings, variant};
use crate::measure::rounds::{Measured, Ratio, Samples, Starter, compare_each};
use crate::scene::Scene;
use crate::session::run::CapacityHints;

/// Rounds after each start: few, because a start is one piece of evidence.
const EACH: usize = 4;

/// A scene, a device, and what the default computes.
pub struct Subject<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    /// The device as it is by default, with buffers that are defined everywhere.
    device: Device,
    default: Computed,
}

/// What came of a variant before it was timed.
#[derive(Clone, Debug)]
pub enum Tried {
    /// The device lacks this, so the variant is not run.
    Lacks(String),
    /// It computes what the default does: bit for bit, or as the reference allows.
    Proved(Proof),
}

/// The result of one axis.
pub struct Outcome {
    /// What was asked for.
    pub asked: Asked,
    /// What came of each variant.
    pub tried: Vec<Tried>,
    /// The times: the default's, then those of each variant that ran.
    pub samples: Samples,
    /// The ratios to the default of each variant that ran.
    pub ratios: Vec<Vec<Ratio>>,
}

impl Outcome {
    /// The variants that were timed, with their ratios to the default.
    pub fn timed(&self) -> impl Iterator<Item = (&Variant, &[Ratio])> {
        let pairs = self.asked.variants.iter().zip(&self.tried);
        let ran = pairs.filter(|(_, tried)| matches!(tried, Tried::Proved(_))).map(|(variant, _)| variant);
        ran.zip(self.ratios.iter().map(Vec::as_slice))
    }
}

impl<'a> Subject<'a> {
    /// Runs the default's frames.
    pub fn new(scene: &'a Scene, device: &Device, settings: &'a Settings) -> Result<Self> {
        let device = cleared(device, &Choices::default())?;
        let default = computed(scene, &device, settings)?;
        Ok(Self { scene, settings, device, default })
    }

    /// Proves each variant, tells what came of it, and times those that ran. Fails if one computes something else.
    pub fn vary(&self, asked: Asked, told: &mut dyn FnMut(&Variant, &Tried) -> Result<()>) -> Result<Outcome> {
        let (mut tried, mut ran) = (Vec::new(), Vec::new());
        for variant in &asked.variants {
            let found = match lack(self.device.adapter(), &variant.choices) {
                Some(lack) => Tried::Lacks(lack),
                None => {
                    ran.push(variant);
                    Tried::Proved(self.prove(variant)?)
                }
            };
            told(variant, &found)?;
            tried.push(found);
        }
        if ran.is_empty() {
            return Ok(Outcome { asked, tried, samples: Samples::default(), ratios: Vec::new() });
        }
        let default = Variant { name: "default".into(), choices: Choices::default() };
        let all: Vec<&Variant> = std::iter::once(&default).chain(ran).collect();
        let open = |choices: &Choices| self.device.opened_as(choices);
        let Measured { samples, .. } = match asked.axis.name {
            "cache" => compare_first_frames(self.scene, &all, &open, self.settings)?,
            _ => self.compare_frames(&all, &open)?,
        };
        let ratios = samples.ratios();
        Ok(Outcome { asked, tried, samples, ratios })
    }

    /// Runs a variant's frames, and compares all buffers with the default's.
    fn prove(&self, variant: &Variant) -> Result<Proof> {
        let mut device = cleared(&self.device, &variant.choices)?;
        match variant.choices.cache {
            Cache::Cold | Cache::Without => {}
            Cache::Warm => {
                computed(self.scene, &device, self.settings)?;
                device = device.forgetting_kernels();
            }
            Cache::Disk => device.renew_pipeline_cache(&self.device.pipeline_cache_content()?)?,
        }
        let own = computed(self.scene, &device, self.settings)?;
        let fixture = || Fixture::new(&self.scene.name, self.scene, self.settings.options, CapacityHints::default());
        proof(&variant.name, [&self.default, &own], &device, &fixture)
    }

    /// Times frames in turn; each start opens the device anew.
    fn compare_frames(&self, variants: &[&Variant], open: &dyn Fn(&Choices) -> Result<Device>) -> Result<Measured> {
        let starter = |chosen: &&Variant| {
            let (name, choices) = (chosen.name.clone(), chosen.choices.clone());
            let start = move || Ok(Box::new(variant(self.scene, Some(&open(&choices)?), self.settings)?) as _);
            Starter { name, start: Box::new(start) }
        };
        let mut starters: Vec<Starter<'_>> = variants.iter().map(starter).collect();
        let schedule = self.settings.schedule();
        compare_each(&mut starters, &schedule, EACH.min(schedule.rounds.max(1)))
    }
}

/// A device used as chosen whose buffers hold zeros at first.
fn cleared(device: &Device, choices: &Choices) -> Result<Device> {
    device.opened_as(&Choices { fill: Some(0), ..choices.clone() })
}
