//! Early termination of the program.

use std::process::{Child, ExitCode, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Whether work is under way that can end early with what there is.
static MAY_END: AtomicBool = AtomicBool::new(false);
/// Whether it is to end.
static ENDS: AtomicBool = AtomicBool::new(false);

/// On Ctrl-C, a hang-up or a request to terminate, ends the child process, removes partial files, and ends the program
/// with exit code 128 plus the signal's number: 130 for Ctrl-C. The first Ctrl-C only asks work that can end early to
/// do so. Writing a file larger than the system allows remains an ordinary error.
#[cfg(unix)]
pub fn remove_when_stopped() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGHUP, SIGINT, SIGTERM, SIGXFSZ]) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever().filter(|signal| *signal != SIGXFSZ) {
            if signal == SIGINT && MAY_END.load(Ordering::Relaxed) && !ENDS.swap(true, Ordering::Relaxed) {
                continue;
            }
            kill();
            milkglass::internals::view::atomic_file::abandon(|| signal_hook::low_level::exit(128 + signal));
        }
    });
}

/// Elsewhere the system's default applies.
#[cfg(not(unix))]
pub fn remove_when_stopped() {}

/// The process that this one has started and waits for, if any.
static CHILD: Mutex<Option<Child>> = Mutex::new(None);

fn child() -> MutexGuard<'static, Option<Child>> {
    CHILD.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Keeps a process that was started, so that it ends when this one is stopped.
pub(super) fn guard(started: Child) {
    *child() = Some(started);
}

/// Kills that process.
pub(super) fn kill() {
    if let Some(child) = child().as_mut() {
        let _ = child.kill();
    }
}

/// Waits for that process until this time, then kills it; returns its status if it ended by itself.
pub(super) fn wait(end: Instant) -> Option<ExitStatus> {
    loop {
        let status = child().as_mut().map(Child::try_wait);
        match status {
            Some(Ok(None)) if Instant::now() < end => std::thread::sleep(Duration::from_millis(5)),
            Some(Ok(Some(status))) => {
                *child() = None;
                return Some(status);
            }
            _ => {
                kill();
                if let Some(mut child) = child().take() {
                    let _ = child.wait();
                }
                return None;
            }
        }
    }
}

/// Says whether the work under way can end early: the first Ctrl-C then asks it to.
pub(super) fn may_end(early: bool) {
    MAY_END.store(early, Ordering::Relaxed);
}

/// Whether Ctrl-C has asked the work under way to end.
pub(super) fn ends() -> bool {
    ENDS.load(Ordering::Relaxed)
}

/// Ends the program with this code; after a device failure without waiting for the driver.
pub fn leave(code: u8) -> ExitCode {
    #[cfg(unix)]
    if code == 3 {
        signal_hook::low_level::exit(code.into());
    }
    ExitCode::from(code)
}
