//! A bar on standard error while a long measurement or a random walk runs; nothing where standard error is no terminal.

use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};
use milkglass::internals::session::walk::WalkProgress;
use milkglass::measure::progress::Observer;

/// The bar of the work under way.
#[derive(Default)]
pub(super) struct Bar(Mutex<Option<ProgressBar>>);

impl Bar {
    fn with(&self, does: impl FnOnce(&mut Option<ProgressBar>)) {
        does(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Observer for Bar {
    fn begin(&self, steps: usize) {
        let style = ProgressStyle::with_template("{pos}/{len} {msg} {wide_bar}");
        let bar = ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        self.with(|shown| *shown = Some(bar));
    }

    fn says(&self, message: &str) {
        self.with(|shown| shown.iter().for_each(|bar| bar.set_message(message.to_string())));
    }

    fn step(&self) {
        self.with(|shown| shown.iter().for_each(|bar| bar.inc(1)));
    }

    fn end(&self) {
        self.with(|shown| shown.take().iter().for_each(ProgressBar::finish_and_clear));
    }
}

/// The bar of the walk under way, in thousandths.
static WALK: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Shows how far a walk has got, or that it is over.
pub(super) fn show_walk(progress: Option<&WalkProgress>) {
    let mut shown = WALK.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(progress) = progress else {
        shown.take().iter().for_each(ProgressBar::finish_and_clear);
        return;
    };
    // A bar is drawn at most every 50 ms, on the first change after that: set everything before it is drawn first.
    let (prefix, message) = (format!("walk, object {}", progress.object), so_far(progress));
    let position = (1000.0 * progress.done) as u64;
    match &*shown {
        Some(bar) if bar.prefix() == prefix => {
            bar.set_message(message);
            bar.set_position(position);
        }
        _ => {
            let style = ProgressStyle::with_template("{prefix}: {msg} {wide_bar}");
            let bar = ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            let bar = bar.with_prefix(prefix).with_message(message).with_position(position);
            bar.tick();
            shown.replace(bar).iter().for_each(ProgressBar::finish_and_clear);
        }
    }
}

/// Writes a line to standard error, above the bar if there is one.
pub(super) fn tell_beside(line: &str) {
    match &*WALK.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(bar) => bar.suspend(|| tell!("{line}")),
        None => tell!("{line}"),
    }
}

/// `error 4.10 % of 2 %, 12 s left`.
fn so_far(progress: &WalkProgress) -> String {
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let goal = progress.goal.map_or(String::new(), |goal| format!(" of {} %", 100.0 * goal));
    let error = progress.noise.map_or("error unknown yet".into(), |noise| format!("error {}{goal}", percent(noise)));
    progress.left.map_or(error.clone(), |left| format!("{error}, {} left", time(left)))
}

/// A time in its largest unit of seconds, minutes and hours.
fn time(seconds: f64) -> String {
    match seconds.ceil() as u64 {
        seconds @ 0..120 => format!("{seconds} s"),
        seconds @ 120..7200 => format!("{} min", seconds.div_ceil(60)),
        seconds => format!("{} h", seconds.div_ceil(3600)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_says_its_error_and_its_time() {
        let walk = |noise, left, goal| so_far(&WalkProgress { object: 0, done: 0.1, left, noise, goal });
        assert_eq!(walk(Some(0.041), Some(11.2), Some(0.02)), "error 4.10 % of 2 %, 12 s left");
        assert_eq!(walk(None, None, Some(0.02)), "error unknown yet");
        assert_eq!(walk(Some(0.5), Some(7300.0), None), "error 50.00 %, 3 h left");
        assert_eq!([time(0.0), time(118.5), time(121.0)], ["0 s", "119 s", "3 min"]);
    }
}
