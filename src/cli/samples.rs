//! Tells how long the samples of a picture will take, and why, before the first one if that is long; and shows a bar.

use std::collections::BTreeMap;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use super::run_frame;
use milkglass::Result;
use milkglass::internals::gpu::Timing;
use milkglass::internals::pipeline::frame::stage;
use milkglass::internals::pipeline::plan::Change;
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Need;
use milkglass::internals::view::pixel_shadow;
use milkglass::scene::{Light, Receivers, Source};

/// Seconds from which the samples that are left count as long.
const LONG: f64 = 5.0;

/// Pixels times samples from which a small picture is timed first; a picture with fewer does not take long.
const LARGE: f64 = 1e6;
/// Pixels of the small picture, about.
const SMALL: f64 = 4096.0;

/// Tells how long a large picture will take, if that is long, from a small picture that this renders; this also solves
/// the session's light. Returns the times of the first frame's steps; none if nothing was timed.
pub fn foretell(session: &mut Session) -> Result<Option<Vec<Timing>>> {
    let camera = session.scene().camera.clone();
    let [width, height] = camera.size.map(f64::from);
    let samples = f64::from(camera.samples);
    let by_pixel = session.state().objects.iter().any(|object| object.by_pixel);
    // With fewer samples than triangles the light would be found at pixels, and once more for the picture.
    let faces: usize =
        session.state().objects.iter().filter(|object| !object.opaque).map(|object| object.count.faces).sum();
    let least = match session.scene().transport.receivers {
        Receivers::Auto => 1.2 * faces as f64 / f64::from(camera.samples),
        Receivers::Faces | Receivers::Pixels => 0.0,
    };
    let share = SMALL.max(least) / (width * height);
    if width * height * samples < LARGE || by_pixel || share > 0.1 {
        return Ok(None);
    }
    let size = [width, height].map(|side| ((side * share.sqrt()).ceil() as u32).max(1));
    session.set_camera(&camera.clone().sized(size)?)?;
    let times = run_frame(session, Change::EVERYTHING)?;
    let scale = width * height * samples / (f64::from(size[0]) * f64::from(size[1]));
    let seconds = |steps: &[Timing]| -> f64 {
        1e-3 * scale * steps.iter().map(|step| step.milliseconds).filter(|ms| ms.is_finite()).sum::<f64>()
    };
    let mut steps = of_picture(times.clone());
    if seconds(&steps) >= LONG {
        // Once more: the first time a driver may still compile kernels.
        steps = of_picture(session.frame(Change::VIEW)?);
    }
    if let Some(line) = long(seconds(&steps), "the picture takes", &steps, fewer(&session.scene().lights).as_deref()) {
        tell!("{line}");
    }
    session.set_camera(&camera)?;
    Ok(Some(times))
}

/// The steps whose time grows with the picture.
fn of_picture(mut steps: Vec<Timing>) -> Vec<Timing> {
    steps.retain(|step| {
        let name = step.name.split(' ').next().unwrap_or_default();
        stage(name).is_some_and(|stage| stage.needs.contains(&Need::Picture))
    });
    steps
}

/// The progress of a picture's samples.
pub struct Samples {
    /// When they began; none if no line is to tell how long they take.
    start: Option<Instant>,
    bar: ProgressBar,
    /// The key that makes its rays fewer, if a light has several samples.
    fewer: Option<String>,
}

impl Samples {
    /// The start of a session's samples; `foretold` if [`foretell`] has told how long they take.
    pub fn new(session: &Session, foretold: bool) -> Self {
        let bar = match session.scene().camera.samples {
            1 => ProgressBar::hidden(),
            samples => ProgressBar::new(samples.into()),
        };
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} samples, {eta} left") {
            bar.set_style(style);
        }
        Self { start: (!foretold).then(Instant::now), bar, fewer: fewer(&session.scene().lights) }
    }

    /// Samples whose progress is not shown, such as those of one frame among many.
    pub fn hidden() -> Self {
        Self { start: None, bar: ProgressBar::hidden(), fewer: None }
    }

    /// Counts a sample; the first one that is counted tells how long the others will take.
    pub fn tell(&mut self, done: u32, all: u32, steps: &[Timing]) {
        let first = self.start.take();
        let left = first.map_or(0.0, |start| start.elapsed().as_secs_f64() * f64::from(all - done));
        let what = format!("{} more samples a pixel take", all - done);
        if let Some(line) = long(left, &what, steps, self.fewer.as_deref()) {
            self.bar.suspend(|| tell!("{line}"));
        }
        self.bar.set_position(done.into());
        if done == all {
            self.bar.finish_and_clear();
        }
    }
}

/// A line about `what`, which takes this many seconds, if that is long.
fn long(seconds: f64, what: &str, steps: &[Timing], fewer: Option<&str>) -> Option<String> {
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
    let fewer = fewer
        .filter(|_| shadows)
        .map_or(" or a lower --samples".to_string(), |key| format!(", a lower --samples or {key}"));
    let share = share.unwrap_or_default();
    Some(format!("long: {what} about {seconds:.0} s{share}; a smaller --size{fewer} takes less"))
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
        let step = |name: &str, milliseconds| Timing { name: name.into(), milliseconds, ..Timing::default() };
        let shadows = pixel_shadow::STAGE.name;
        let steps = [step(shadows, 600.0), step("other", 100.0), step(shadows, 300.0)];
        assert_eq!(long(4.9, "it takes", &steps, None), None);
        let line = long(70.0, "7 more samples a pixel take", &steps, Some("light.0.occlusion"));
        let words = format!(
            "long: 7 more samples a pixel take about 70 s, 90 % of it in {shadows}; a smaller --size, a \
             lower --samples or light.0.occlusion takes less"
        );
        assert_eq!(line, Some(words));
        let line =
            long(9.0, "the picture takes", &[step("other", f64::NAN)], Some("light.0.samples")).unwrap_or_default();
        assert_eq!(line, "long: the picture takes about 9 s; a smaller --size or a lower --samples takes less");
    }
}
