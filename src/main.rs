//! The command line: runs the command that the arguments name; an error becomes one message and an exit code.

use std::io::Write;
use std::process::ExitCode;

use milkglass::cli::{leave, remove_when_stopped, run};

fn main() -> ExitCode {
    remove_when_stopped();
    match run(std::env::args_os()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "milkglass: {error}");
            leave(error.exit_code())
        }
    }
}
