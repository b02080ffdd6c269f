//! A bar on standard error while a long measurement runs; nothing where that is no terminal.

use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};
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
        let style = ProgressStyle::with_template("{pos}/{len} {wide_bar} {msg}");
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
