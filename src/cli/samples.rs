//! How far the samples of a picture are: a bar, and, where they take long, how long and why, said after the first one.

use std::collections::BTreeMap;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use milkglass::internals::gpu::Timing;
use milkglass::internals::session::run::Session;
use milkglass::internals::view::pixel_shadow;
use milkglass::scene::{Light, Source};

/// Seconds from which the samples that are left count as long.
const LONG: f64 = 5.0;

/// The progress of a picture's samples.
pub struct Samples {
    /// When they began; none if nothing is said.
    start: Option<Instant>,
    bar: ProgressBar,
    /// What makes its rays fewer, if a light has several samples.
    fewer: Option<String>,
}

impl Samples {
    /// The start of a session's samples.
    pub fn new(session: &Session) -> Self {
        let bar = match session.scene().camera.samples {
            1 => ProgressBar::hidden(),
            samples => ProgressBar::new(samples.into()),
        };
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} samples, {eta} left") {
            bar.set_style(style);
        }
        Self { start: Some(Instant::now()), bar, fewer: fewer(&session.scene().lights) }
    }

    /// Samples that nothing is said about, as those of a frame among many.
    pub fn hidden() -> Self {
        Self { start: None, bar: ProgressBar::hidden(), fewer: None }
    }

    /// Counts a sample; the first one tells how long the others will take.
    pub fn tell(&mut self, done: u32, all: u32, steps: &[Timing]) {
        let first = self.start.filter(|_| done == 1);
        let left = first.map_or(0.0, |start| start.elapsed().as_secs_f64() * f64::from(all - done));
        if let Some(line) = long(left, all - done, steps, self.fewer.as_deref()) {
            self.bar.suspend(|| tell!("{line}"));
        }
        self.bar.inc(1);
        if done == all {
            self.bar.finish_and_clear();
        }
    }
}

/// What to say about so many samples that will take so many seconds, if that is long.
fn long(seconds: f64, samples: u32, steps: &[Timing], fewer: Option<&str>) -> Option<String> {
    if seconds < LONG {
        return None;
    }
    let mut stages: BTreeMap<&str, f64> = BTreeMap::new();
    for step in steps.iter().filter(|step| step.milliseconds.is_finite()) {
        *stages.entry(step.name.split(' ').next().unwrap_or_default()).or_default() += step.milliseconds;
    }
    let total: f64 = stages.values().sum();
    let most = stages.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| total > 0.0);
    let share = most.map(|(stage, time)| format!(", {:.0} % of it in {stage}", 100.0 * time / total));
    let shadows = most.is_some_and(|(stage, _)| stage == pixel_shadow::STAGE.name);
    let fewer = fewer.filter(|_| shadows).map(|key| format!(" or {key}")).unwrap_or_default();
    let share = share.unwrap_or_default();
    Some(format!(
        "long: {samples} more samples a pixel take about {seconds:.0} s{share}; a lower --samples{fewer} takes less"
    ))
}

/// The key of the light with most samples.
fn fewer(lights: &[Light]) -> Option<String> {
    let (number, light) = lights.iter().enumerate().max_by_key(|(_, light)| light.samples())?;
    let key = if matches!(light.source, Source::Environment { .. }) { "occlusion" } else { "samples" };
    (light.samples() > 1).then(|| format!("light.{number}.{key}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_samples_are_announced() {
        let step = |name: &str, milliseconds| Timing { name: name.into(), milliseconds, start: 0.0 };
        let shadows = pixel_shadow::STAGE.name;
        let steps = [step(shadows, 600.0), step("other", 100.0), step(shadows, 300.0)];
        assert_eq!(long(4.9, 7, &steps, None), None);
        let line = long(70.0, 7, &steps, Some("light.0.occlusion"));
        let words = format!(
            "long: 7 more samples a pixel take about 70 s, 90 % of it in {shadows}; a lower --samples or \
             light.0.occlusion takes less"
        );
        assert_eq!(line, Some(words));
        let line = long(9.0, 1, &[step("other", f64::NAN)], Some("light.0.samples")).unwrap_or_default();
        assert_eq!(line, "long: 1 more samples a pixel take about 9 s; a lower --samples takes less");
    }
}
