//! Early termination of the program.

use std::process::ExitCode;

/// On Ctrl-C or a request to terminate, removes partial files before the program ends with exit code 130, or 128 plus
/// the signal's number. Writing a file larger than the system allows remains an ordinary error.
#[cfg(unix)]
pub fn remove_when_stopped() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGHUP, SIGINT, SIGTERM, SIGXFSZ]) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever().filter(|signal| *signal != SIGXFSZ) {
            milkglass::internals::view::atomic_file::abandon(|| signal_hook::low_level::exit(128 + signal));
        }
    });
}

/// Elsewhere the system's default applies.
#[cfg(not(unix))]
pub fn remove_when_stopped() {}

/// Ends the program with this code; after a device failure without waiting for the driver.
pub fn leave(code: u8) -> ExitCode {
    #[cfg(unix)]
    if code == 3 {
        signal_hook::low_level::exit(code.into());
    }
    ExitCode::from(code)
}
