//! How the program ends before its time.

use std::process::ExitCode;

/// Ctrl-C, and being asked to end, remove what is half written before they stop the program: exit code 130, or 128 and
/// the signal's number. A file that grows beyond what the system allows is an error like any other.
#[cfg(unix)]
pub fn remove_when_stopped() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGHUP, SIGINT, SIGTERM, SIGXFSZ]) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever().filter(|signal| *signal != SIGXFSZ) {
            milkglass::view::atomic_file::abandon(|| signal_hook::low_level::exit(128 + signal));
        }
    });
}

/// Elsewhere the system's own ways of stopping hold.
#[cfg(not(unix))]
pub fn remove_when_stopped() {}

/// Ends the program with this code. After a device has failed, without waiting for what its driver still does.
pub fn leave(code: u8) -> ExitCode {
    #[cfg(unix)]
    if code == 3 {
        signal_hook::low_level::exit(code.into());
    }
    ExitCode::from(code)
}
