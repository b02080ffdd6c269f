//! Runs a sweep: every method at every setting that the budget allows, warmed up, then several timed frames each.

use std::time::Instant;

use super::pace::Pace;
use super::{Bench, Equation, Leaves, Lighting, Method, Opened, Point, Run, Sweep, Yardstick};
use crate::error::Result;
use crate::measure::progress::Progress;
use crate::measure::statistics::median;
use crate::measure::truth::Truth;

/// What is measured, and the time budget.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The methods, in the order of the tables.
    pub methods: Vec<&'static Method>,
    /// Number of settings per method, from the coarsest.
    pub values: usize,
    /// Timed frames per point, after the first; the median is reported. At least 1.
    pub repeat: usize,
    /// Number of receivers at which errors are measured, at least 1.
    pub samples: usize,
    /// Seed of the receivers.
    pub seed: u64,
    /// Time budget in seconds for all frames of one point, above 0.
    pub budget: f64,
    /// The result of a walk, to compare with as well.
    pub truth: Option<Truth>,
}

/// Measures all points.
pub fn sweep(bench: &Bench<'_>, settings: &Settings) -> Result<Sweep> {
    let values = |method: &Method| method.values.len().min(settings.values);
    let solved = settings.methods.iter().filter(|method| method.equation == Equation::Diffusion);
    let finest = solved.map(|method| method.values[values(method) - 1]).reduce(f64::min);
    let yardstick =
        Yardstick::new(bench.scene, settings.samples, settings.seed)?.with_diffusion(bench.scene, finest)?;
    let count = settings.methods.iter().map(|method| values(method) * Lighting::ALL.len()).sum::<usize>();
    let progress = Progress::new(count);
    let mut points = Vec::new();
    let mut pace = Pace::open(bench.device)?;
    let mut before = pace.seconds()?;
    for &method in &settings.methods {
        let course = || Course { settings, seconds: Vec::new(), beyond: false };
        let mut courses = Lighting::ALL.map(|lighting| (lighting, course()));
        for &value in method.values.iter().take(values(method)) {
            for (lighting, course) in &mut courses {
                let mut point = Point { method, value, lighting: *lighting, run: Err(String::new()) };
                progress.says(&format!("{} {}, {}", method.name, point.setting(), lighting.name()));
                point.run = course.measure(bench, &yardstick, &point)?;
                let after = pace.seconds()?;
                if let Ok(run) = &mut point.run {
                    run.busy = before.max(after);
                }
                before = after;
                points.push(point);
                progress.step();
            }
        }
    }
    for run in points.iter_mut().filter_map(|point: &mut Point| point.run.as_mut().ok()) {
        run.busy = pace.share(run.busy);
    }
    let midpoint = yardstick.discretisation(Leaves::Midpoint);
    let truth = settings.truth.as_ref().map(|truth| truth.about.clone());
    Ok(Sweep { points, samples: yardstick.samples(), midpoint, truth })
}

/// The progress of one method under one lighting, from coarse to fine.
struct Course<'a> {
    settings: &'a Settings,
    /// The measured settings and the seconds that each took, including its opening.
    seconds: Vec<(f64, f64)>,
    /// Whether a setting exceeded the budget; then all finer ones are skipped.
    beyond: bool,
}

impl Course<'_> {
    /// Measures a point, or returns the reason why not.
    fn measure(
        &mut self,
        bench: &Bench<'_>,
        yardstick: &Yardstick,
        point: &Point,
    ) -> Result<std::result::Result<Run, String>> {
        if self.beyond {
            return Ok(Err("finer than a setting beyond the budget".into()));
        }
        let repeat = self.settings.repeat;
        let expected = match (self.seconds.is_empty(), point.method.foretell) {
            (true, Some(foretell)) => foretell(bench, point.lighting)? * (repeat + 1) as f64,
            _ => foretold(&self.seconds, point.value),
        };
        if let Some(why) = self.excess(expected) {
            return Ok(Err(why));
        }
        let start = Instant::now();
        let mut solver = match (point.method.open)(bench, point.lighting, point.value)? {
            Opened::Ready(solver) => solver,
            Opened::NotOffered(why) => return Ok(Err(why)),
        };

        // The first timed frame shows whether the others fit the budget.
        let (mut walls, mut devices) = (Vec::new(), Vec::new());
        for frame in 0..repeat {
            solver.before()?;
            let before = Instant::now();
            devices.push(solver.frame()?);
            let seconds = before.elapsed().as_secs_f64();
            walls.push(seconds * 1e3);
            if frame == 0
                && let Some(why) = self.excess(start.elapsed().as_secs_f64() + seconds * (repeat - 1) as f64)
            {
                return Ok(Err(why));
            }
        }
        self.seconds.push((point.value, start.elapsed().as_secs_f64()));
        walls.sort_by(f64::total_cmp);
        let devices: Vec<f64> = devices.into_iter().flatten().collect();
        let radiosity = solver.radiosity()?;
        let [own, total] = yardstick.errors(point.method, &radiosity);
        Ok(Ok(Run {
            device_ms: (devices.len() == walls.len()).then(|| median(devices)),
            range_ms: [walls[0], walls[walls.len() - 1]],
            wall_ms: median(walls),
            busy: 1.0,
            own,
            total,
            truth: self.settings.truth.as_ref().map(|truth| truth.error(&radiosity)),
            links_per_face: solver.links_per_face()?,
        }))
    }

    /// The reason to leave out a point that takes this many seconds, if it exceeds the budget.
    fn excess(&mut self, seconds: f64) -> Option<String> {
        let budget = self.settings.budget;
        self.beyond = seconds > budget;
        self.beyond.then(|| format!("would take {seconds:.0} s or so, beyond --budget {budget}"))
    }
}

/// Predicted seconds at the next setting: a power law through the last two, or the last time.
fn foretold(seconds: &[(f64, f64)], value: f64) -> f64 {
    match seconds {
        [.., (v0, t0), (v1, t1)] if v0 != v1 => {
            let slope = (t1 / t0).ln() / (v1 / v0).ln();
            t1 * (value / v1).powf(slope.clamp(-4.0, 0.0))
        }
        [.., (_, last)] => *last,
        [] => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_time_follows_the_last_two() {
        assert_eq!(foretold(&[], 0.1), 0.0);
        assert_eq!(foretold(&[(0.2, 3.0)], 0.1), 3.0);
        assert!((foretold(&[(0.2, 1.0), (0.1, 4.0)], 0.05) - 16.0).abs() < 1e-12);
        assert!((foretold(&[(0.2, 4.0), (0.1, 1.0)], 0.05) - 1.0).abs() < 1e-12, "noise is no trend");
    }

    #[test]
    fn what_is_beyond_the_budget_ends_the_course() {
        let settings =
            Settings { methods: Vec::new(), values: 1, repeat: 5, samples: 1, seed: 1, budget: 10.0, truth: None };
        let mut course = Course { settings: &settings, seconds: Vec::new(), beyond: false };
        assert_eq!(course.excess(9.9), None);
        assert!(course.excess(11.0).is_some_and(|why| why.contains("11 s") && why.contains("--budget 10")));
        assert!(course.beyond);
    }
}
