//! `milkglass scenes` and `milkglass materials`: what is built in.

use clap::Args;

use super::{print, table};
use milkglass::error::{Input, Result};
use milkglass::scene::{BUILTIN, PRESETS};

/// Arguments of `scenes`.
#[derive(Args)]
#[command(after_help = "Example: milkglass scenes lotus > mine.toml")]
pub struct Scenes {
    /// Print this scene's TOML, to copy and edit.
    name: Option<String>,
}

/// Lists the built-in scenes, or prints one.
pub fn scenes(arguments: &Scenes) -> Result<()> {
    let Some(name) = &arguments.name else {
        let rows: Vec<_> = BUILTIN.iter().map(|(name, _, about)| vec![name.to_string(), about.to_string()]).collect();
        print(&table(&["scene", "what it shows"], &[], &rows))?;
        return Ok(());
    };
    match BUILTIN.iter().find(|(known, _, _)| known.eq_ignore_ascii_case(name)) {
        Some((_, text, _)) => {
            print(text)?;
            Ok(())
        }
        None => {
            let known: Vec<_> = BUILTIN.iter().map(|(name, _, _)| *name).collect();
            Err(Input::new("no built-in scene has this name").found(name).expected(known.join(", ")).into())
        }
    }
}

/// Lists the presets of Jensen et al. 2001.
pub fn materials() -> Result<()> {
    let three = |v: [f64; 3]| v.map(|x| x.to_string()).join(" ");
    let rows: Vec<_> = PRESETS
        .iter()
        .map(|m| {
            let (s, a, r) = (three(m.sigma_s_prime), three(m.sigma_a), three(m.diffuse_reflectance));
            vec![m.name.to_string(), s, a, m.eta.to_string(), r]
        })
        .collect();
    print(&table(
        &["material", "sigma_s' per mm (r g b)", "sigma_a per mm (r g b)", "eta", "diffuse reflectance (r g b)"],
        &[],
        &rows,
    ))?;
    Ok(())
}
