//! What the command line says of random walks.

use std::sync::OnceLock;
use std::time::Duration;

use clap::Args;

use super::progress::{show_walk, tell_beside};
use super::stop::{ends, may_end};
use milkglass::error::Result;
use milkglass::internals::pipeline::plan::ShadingMethod;
use milkglass::internals::session::walk::{WalkControl, WalkReport};
use milkglass::measure::truth::Truth;
use milkglass::{Device, Scene, Session};

/// The limit that the command line gives, if it gives one.
static LIMIT: OnceLock<Duration> = OnceLock::new();

/// How long a walk may take.
#[derive(Args)]
pub(super) struct LimitArgument {
    /// The longest that a random walk may take, such as 90, 90s, 5m or 2h: one that will take longer is refused.
    #[arg(long, value_name = "TIME", value_parser = parse)]
    limit_time: Option<Duration>,
}

impl LimitArgument {
    /// Makes the limit hold for all walks from here on.
    pub(super) fn hold(&self) {
        if let Some(limit) = self.limit_time {
            let _ = LIMIT.set(limit);
        }
    }
}

/// Parses `90s`: a number above 0, and optionally s, m or h.
fn parse(text: &str) -> std::result::Result<Duration, String> {
    let (digits, unit) = match text.char_indices().next_back() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    let seconds = digits.parse::<f64>().ok().map(|n| n * unit).filter(|&n| n > 0.0);
    let time = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    time.ok_or_else(|| "expected a number of seconds above 0, or such as 90s, 5m, 2h".to_string())
}

/// The control of walks that tell how long they take and show how far they are, are refused if they would take too
/// long, and end early on Ctrl-C.
pub(super) fn control() -> WalkControl {
    let limit = LIMIT.get().copied();
    WalkControl { limit, stop: Some(ends), tell: Some(tell_beside), show: Some(show_walk), ..WalkControl::default() }
}

/// Gives a session's walks this control.
pub(super) fn watch(session: &mut Session) {
    may_end(session.plan().options().transport == ShadingMethod::Walk);
    session.watch_walk(control());
    if let Some(caveat) = session.walk_caveat() {
        tell!("{caveat}");
    }
}

/// The walk that `--truth` names.
pub(super) fn truth(name: &str, scene: &Scene, device: Option<&Device>) -> Result<Truth> {
    may_end(true);
    let found = Truth::find(name, scene, device, control());
    may_end(false);
    found
}

/// Says on standard error what became of the light in the last frame's walks, or how exactly diffusion was solved.
pub(super) fn tell_walks(session: &Session) {
    may_end(false);
    for report in session.solve_reports() {
        let left = report.residual.map(|share| format!("{share:.1e}")).join(" ");
        let ends = if report.converged { "" } else { ", not as small as asked" };
        tell!("diffusion, object {}: {} steps, residual {left}{ends}", report.object, report.steps);
    }
    for report in session.walk_reports() {
        tell!("{}", line(report));
    }
}

fn line(report: &WalkReport) -> String {
    let percent = |shares: [f64; 3]| shares.map(|share| format!("{:.3}", 100.0 * share)).join(" ");
    let noise = report.noise.into_iter().fold(0.0, f64::max);
    let rate = 3.0 * f64::from(report.photons) / report.seconds.max(1e-9);
    format!(
        "walk, object {}: {} photons a channel, {:.1} s ({rate:.2e} a second), noise {:.2} %{}; of the light that entered, \
         %: left {}, straight through {}, absorbed {}, lost {}",
        report.object,
        report.photons,
        report.seconds,
        100.0 * noise,
        if report.stopped { ", stopped before its end" } else { "" },
        percent(report.left),
        percent(report.straight),
        percent(report.absorbed),
        percent(report.lost),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_numbers_with_a_unit() {
        let seconds = |text: &str| parse(text).map(|time| time.as_secs_f64());
        assert_eq!(
            [seconds("90"), seconds("1.5m"), seconds("2h"), seconds("3s")].map(|time| time.unwrap()),
            [90.0, 90.0, 7200.0, 3.0]
        );
        for text in ["", "0", "-3", "m", "nan", "1d", "1e300h"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
