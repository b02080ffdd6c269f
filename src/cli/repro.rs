//! `milkglass replay`: runs what `dump` and `conform --dump` wrote; and what the three share.

use std::path::{Path, PathBuf};

use clap::Args;

use super::device::opened;
use super::replace::ReplaceArgument;
use super::{print, size, table};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Adapter, Device, Instance};
use milkglass::measure::folder::CASE;
use milkglass::measure::repro::Case;
use milkglass::measure::repro::minimize::minimize;

/// A Vulkan device.
#[derive(Args)]
pub(super) struct Chosen {
    /// A device's number in `milkglass devices`, or part of its name [default: the best Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
    /// Run without the validation layer.
    #[arg(long)]
    no_validation: bool,
}

impl Chosen {
    /// Opens it.
    pub(super) fn open(&self) -> Result<Device> {
        let instance = Instance::open(!self.no_validation)?;
        let adapters = instance.adapters()?;
        let found = match &self.device {
            Some(wish) if wish.eq_ignore_ascii_case("cpu") => {
                let fault = Input::new("kernels run on a Vulkan device only").key("--device").found("cpu");
                return Err(fault.expected("a device that `milkglass devices` lists").into());
            }
            Some(wish) => Some(Adapter::find(&adapters, wish)?),
            None => Adapter::best(&adapters),
        };
        let none = || Error::device("looking for a device", "there is no usable Vulkan device");
        opened(&instance, found.ok_or_else(none)?)
    }
}

/// Arguments of `replay`.
#[derive(Args)]
#[command(after_help = "Example: milkglass replay failures/push-sliver --device 0\n         \
                        milkglass replay failures --replace transport/blocks/push=my.comp")]
pub struct Arguments {
    /// A folder that `dump` wrote, or one with several of them.
    folder: PathBuf,
    #[command(flatten)]
    device: Chosen,
    #[command(flatten)]
    replace: ReplaceArgument,
    /// Run each case this many times: a race may show in one of them only.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    times: u32,
}

/// Replays the cases; fails if one of them is beyond tolerance.
pub fn run(arguments: &Arguments) -> Result<()> {
    let kernels = arguments.replace.load()?;
    let mut cases = Vec::new();
    for folder in folders(&arguments.folder)? {
        let mut case = Case::read(&folder)?;
        for (kernel, words) in &kernels {
            case = case.replacing(kernel, words)?;
        }
        cases.push((folder, case));
    }
    let device = arguments.device.open()?;
    let (mut rows, mut failed) = (Vec::new(), 0);
    for (folder, case) in &cases {
        let found = case.replay(&device, arguments.times as usize)?;
        let passes = found.passes();
        failed += usize::from(!passes);
        let wrong: usize = found.wrong.iter().map(|(_, count, _)| count).sum();
        rows.push(vec![
            folder.display().to_string(),
            case.about.stage.clone(),
            case.dispatches.len().to_string(),
            found.words.to_string(),
            wrong.to_string(),
            if passes { "passes".into() } else { "FAILS".into() },
        ]);
        for (_, count, first) in &found.wrong {
            tell!("{}: {count} words beyond tolerance: {first}", folder.display());
        }
        for message in &found.messages {
            tell!("{}: {message}", folder.display());
        }
    }
    let header = ["case", "stage", "dispatches", "words", "wrong", "verdict"];
    print(&format!("{}, {}\n{}", device.name(), device.driver(), table(&header, &[2, 3, 4], &rows)))?;
    match failed {
        0 => Ok(()),
        1 => Err(Error::Check("1 case fails on this device".into())),
        more => Err(Error::Check(format!("{more} cases fail on this device"))),
    }
}

/// The folder itself if it is a case, else those in it that are.
fn folders(folder: &Path) -> Result<Vec<PathBuf>> {
    if folder.join(CASE.page).is_file() {
        return Ok(vec![folder.to_path_buf()]);
    }
    let fault = |what: String| {
        let fault = Input::new(what).file(folder);
        Error::from(fault.expected(format!("a folder with a {}, or with folders that have one", CASE.page)))
    };
    let list = std::fs::read_dir(folder).map_err(|error| fault(format!("not a folder: {error}")))?;
    let mut found: Vec<PathBuf> = list.filter_map(|entry| Some(entry.ok()?.path())).collect();
    found.retain(|path| path.join(CASE.page).is_file());
    found.sort();
    if found.is_empty() { Err(fault("there is no case in it".into())) } else { Ok(found) }
}

/// Writes a case, and says what it holds; `key` is the argument that names the folder.
pub(super) fn written(case: &Case, device: &Device, folder: &Path, key: &str, least: bool) -> Result<String> {
    if !least {
        case.write(folder, key)?;
        return Ok(format!("{}, {}\n", describe(folder, case), amount(case)));
    }
    let less = minimize(case, device)?;
    less.write(folder, key)?;
    Ok(format!("{}, {} -> {}\n", describe(folder, &less), amount(case), amount(&less)))
}

/// Where a case comes from, and what it does.
fn describe(folder: &Path, case: &Case) -> String {
    let about = &case.about;
    let kernels: std::collections::BTreeSet<&str> = case.dispatches.iter().map(|d| d.kernel.as_str()).collect();
    let kernels: Vec<_> = kernels.into_iter().collect();
    let fails = if about.fails { "fails" } else { "conforms" };
    let dispatches = case.dispatches.len();
    format!(
        "{}: {} on {}, {fails}; {} ({}): {dispatches} dispatch{}, {} buffers",
        folder.display(),
        about.step,
        about.fixture,
        kernels.join(", "),
        about.dispatches,
        if dispatches == 1 { "" } else { "es" },
        case.buffers.len(),
    )
}

/// Its groups and bytes.
fn amount(case: &Case) -> String {
    let groups = case.groups();
    format!("{groups} group{}, {}", if groups == 1 { "" } else { "s" }, size(case.bytes() as u64))
}
