//! The command line: arguments to one command, an error to one message and an exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    match milkglass::command::run(std::env::args_os()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("milkglass: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
