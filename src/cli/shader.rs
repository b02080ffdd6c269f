//! `milkglass shader`: prints a built-in kernel's GLSL, as a starting point.

use clap::Args;

use super::print;
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::{source, sources};

/// Arguments of `shader`.
#[derive(Args)]
#[command(after_help = "Example: milkglass shader transport/blocks/gather/direct > my.comp\n         \
                        milkglass profile bunny.obj --replace transport/blocks/gather/direct=my.comp")]
pub struct Arguments {
    /// A kernel, or a file that kernels include; without it, all names are listed.
    name: Option<String>,
}

/// Prints one source, or the names of all.
pub fn run(arguments: &Arguments) -> Result<()> {
    let Some(name) = &arguments.name else {
        return print(&sources().map(|name| format!("{name}\n")).collect::<String>());
    };
    let Some(text) = source(name) else {
        let near = sources().max_by(|a, b| strsim::jaro_winkler(a, name).total_cmp(&strsim::jaro_winkler(b, name)));
        let fault = Input::new("there is no such shader").found(name);
        return Err(fault
            .expected(format!("{}, or another one that `milkglass shader` lists", near.unwrap_or("-")))
            .into());
    };
    print(&text)
}
