//! `milkglass completions` and `milkglass man`: what shells and `man` need, made from the definitions of the arguments.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man as Page;

use super::{Cli, print};
use milkglass::error::{Input, Result};

/// Arguments of `completions`.
#[derive(Args)]
#[command(after_help = "Example: milkglass completions bash > ~/.local/share/bash-completion/completions/milkglass")]
pub struct Completions {
    /// The shell.
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args)]
#[command(after_help = "Example: milkglass man | man -l -\n         milkglass man -o ~/.local/share/man/man1")]
pub struct Man {
    /// Write the page of the program and one of each command to this folder, which must exist.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Prints the script.
pub fn completions(arguments: &Completions) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "milkglass", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Prints the page, or writes all of them.
pub fn man(arguments: &Man) -> Result<()> {
    if let Some(folder) = &arguments.output {
        let fault = |error: std::io::Error| Input::new(error.to_string()).key("-o").found(folder.display());
        return clap_mangen::generate_to(Cli::command(), folder)
            .map_err(|error| fault(error).expected("a folder that can be written to").into());
    }
    let mut page = Vec::new();
    Page::new(Cli::command()).render(&mut page).map_err(|error| Input::new(error.to_string()))?;
    print(&String::from_utf8_lossy(&page))
}
