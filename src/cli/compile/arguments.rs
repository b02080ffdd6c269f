//! Arguments of `compile`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use crate::cli::replace::ReplaceArgument;
use crate::cli::watch::seconds;
use crate::cli::{RunArguments, SceneArguments};
use milkglass::error::{Input, Result};

/// Families of RADV that `--for all` stands for: one or more of each generation since 2016. The last two are names of
/// the same GPU in older and newer versions of Mesa.
pub(super) const FAMILIES: [&str; 11] = [
    "polaris10",
    "vega10",
    "vega20",
    "raven",
    "navi10",
    "navi14",
    "navi21",
    "navi24",
    "rembrandt",
    "gfx1100",
    "navi31",
];

/// Arguments of `compile`.
#[derive(Args)]
#[command(after_help = "Example: milkglass compile lotus --for navi21,gfx1100 --csv lotus.csv\n         \
                        milkglass compile lotus --for navi21,gfx1100 --baseline lotus.csv\n         \
                        milkglass compile --all --for all --isa code",
          mut_arg("scene", |scene| scene.required(false).default_value("").hide_default_value(true)))]
pub struct Arguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Compile for all built-in scenes, and every kernel that none of them has.
    #[arg(long, conflicts_with = "scene")]
    pub(super) all: bool,
    #[command(flatten)]
    pub(super) run: RunArguments,
    #[command(flatten)]
    pub(super) replace: ReplaceArgument,
    /// Compilers: families of AMD GPUs for Mesa's RADV, such as polaris10, vega10, navi10, navi21 or gfx1100; `all` for
    /// ten of them; `here` for the compiler of the device itself.
    #[arg(long = "for", value_name = "FAMILY,...", value_delimiter = ',', default_value = "navi21,gfx1100")]
    pub(super) families: Vec<String>,
    /// Also write what the compilers report except hashes, a row for each value.
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Also write the same as JSON, with the milliseconds that each pipeline took.
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Also write the compilers' code, down to the GPU's instructions: FOLDER/FAMILY/KERNEL.txt.
    #[arg(long, value_name = "FOLDER")]
    pub(super) isa: Option<PathBuf>,
    /// Compare with a file of --csv, and fail where a kernel spills more, uses more scratch memory, has fewer waves, or
    /// takes 10 % more cycles.
    #[arg(long, value_name = "FILE")]
    pub(super) baseline: Option<PathBuf>,
    /// How long a compiler may take, seconds.
    #[arg(long, value_name = "SECONDS", default_value = "600", value_parser = seconds)]
    pub(super) timeout: f64,
    /// Compile in this process.
    #[arg(long, hide = true)]
    pub(super) child: bool,
    /// The folder of a child: it reads the pipelines to compile, and writes the module that is next.
    #[arg(long, hide = true, value_name = "FOLDER", default_value = ".", hide_default_value = true)]
    pub(super) exchange: PathBuf,
}

impl Arguments {
    /// The families, each once, and whether each was typed by its own name.
    pub(super) fn families(&self) -> Result<Vec<(&str, bool)>> {
        let mut all: Vec<(&str, bool)> = Vec::new();
        let typed = self.families.iter().map(|family| family.trim());
        let stood_for = FAMILIES.iter().filter(|_| self.families.iter().any(|family| family.trim() == "all"));
        for (family, typed) in typed.map(|family| (family, true)).chain(stood_for.map(|family| (*family, false))) {
            if family.is_empty() || !family.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') {
                let fault = Input::new("not the name of a family").key("--for").found(format!("{family:?}"));
                return Err(fault.expected("names such as navi21, with commas between them").into());
            }
            if family != "all" && !all.iter().any(|(known, _)| *known == family) {
                all.push((family, typed));
            }
        }
        let here = all.iter().any(|(family, _)| *family == "here");
        if self.run.device.is_cpu() {
            let fault = Input::new("the CPU has no compiler of kernels").key("--device").found("cpu");
            return Err(fault.expected("a device that `milkglass devices` lists").into());
        }
        if self.run.device.words().is_some() && !here {
            let fault = Input::new("goes with --for here only").key("--device");
            return Err(fault.found(self.families.join(",")).into());
        }
        Ok(all)
    }

    /// The words that a child's command line needs of this one.
    pub(super) fn words(&self) -> Vec<OsString> {
        let words = self.replace.words().map(OsString::from).chain(self.run.device.words().map(OsString::from));
        let folder = self.isa.iter().flat_map(|folder| [OsString::from("--isa"), folder.clone().into_os_string()]);
        words.chain(folder).collect()
    }
}
