//! Progress of long measurements, for a program to show: the command line draws a bar.

use std::sync::OnceLock;

/// Shows how far a measurement has got.
pub trait Observer: Send + Sync {
    /// Work of this many steps begins.
    fn begin(&self, steps: usize);
    /// The next step begins; `message` names it.
    fn says(&self, message: &str);
    /// One step is done. Called from any thread.
    fn step(&self);
    /// The work is done.
    fn end(&self);
}

static OBSERVER: OnceLock<Box<dyn Observer>> = OnceLock::new();

/// Sets the observer of all measurements of this process. Only the first call has an effect.
pub fn observe(observer: Box<dyn Observer>) {
    let _ = OBSERVER.set(observer);
}

/// Work under way. Without an observer it shows nothing.
pub(crate) struct Progress(Option<&'static dyn Observer>);

impl Progress {
    /// Begins work of this many steps.
    pub(crate) fn new(steps: usize) -> Self {
        let observer = OBSERVER.get().map(|observer| &**observer);
        if let Some(observer) = observer {
            observer.begin(steps);
        }
        Self(observer)
    }

    /// The next step begins; `message` names it.
    pub(crate) fn says(&self, message: &str) {
        if let Some(observer) = self.0 {
            observer.says(message);
        }
    }

    /// One step is done.
    pub(crate) fn step(&self) {
        if let Some(observer) = self.0 {
            observer.step();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(observer) = self.0 {
            observer.end();
        }
    }
}
