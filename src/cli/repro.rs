//! `milkglass replay`: runs cases that `dump` or `conform --dump` wrote; and functions that the three share.

mod bug;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};

use super::device::opened;
use super::replace::ReplaceArgument;
use super::run_args::quoted;
use super::watch::{itself, seconds, watched};
use super::{print, size, table, write};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Adapter, Device, Instance};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::folder::CASE;
use milkglass::measure::interpreted::{self, DEVICE};
use milkglass::measure::repro::Case;
use milkglass::measure::repro::minimize::minimize;
use milkglass::measure::repro::run::Found;
use milkglass::measure::results::Verdict;

/// The arguments that choose a Vulkan device.
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
    /// Whether it is the interpreter of kernels, which is no Vulkan device.
    fn interprets(&self) -> bool {
        interpreted::is_asked(self.device.as_deref())
    }

    /// Opens the device.
    pub(super) fn open(&self) -> Result<Device> {
        let instance = Instance::open(!self.no_validation)?;
        let adapters = instance.adapters()?;
        opened(&instance, &adapters[self.index(&adapters)?])
    }

    /// Its facts.
    fn look(&self) -> Result<Adapter> {
        if self.interprets() {
            return Ok(interpreted::adapter());
        }
        let adapters = Instance::open(!self.no_validation)?.adapters()?;
        Ok(adapters[self.index(&adapters)?].clone())
    }

    fn index(&self, adapters: &[Adapter]) -> Result<usize> {
        let found = match &self.device {
            Some(wish) if wish.eq_ignore_ascii_case("cpu") => {
                let fault = Input::new("kernels run on a Vulkan device only").key("--device").found("cpu");
                return Err(fault.expected("a device that `milkglass devices` lists").into());
            }
            Some(wish) => Some(Adapter::find(adapters, wish)?),
            None => Adapter::best(adapters),
        };
        let none = || Error::device("looking for a device", "there is no usable Vulkan device");
        let found = found.ok_or_else(none)?;
        Ok(adapters.iter().position(|adapter| std::ptr::eq(adapter, found)).unwrap_or_default())
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
    /// How long a case may take, in a process of its own, seconds [default: for two runs 600, or the limit that it
    /// exceeded before].
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    timeout: Option<f64>,
    /// Also write a report of the case for the driver's developers, as Markdown: what happens, the device, the driver,
    /// the layer, commands that repeat it, and what the compiler says of the kernel.
    #[arg(long, value_name = "FILE")]
    bug: Option<PathBuf>,
    /// Run one case, and write lines of JSON: for the process that has started this one.
    #[arg(long, hide = true)]
    child: bool,
}

impl Arguments {
    /// Fails where a report is asked for of what has none: a case on a device, in Markdown.
    fn report_is_sound(&self, cases: usize) -> Result<()> {
        let Some(file) = &self.bug else { return Ok(()) };
        let (what, found, expected) = if self.device.interprets() {
            ("a report is of a driver", file.display().to_string(), "a Vulkan device")
        } else if file.extension().is_none_or(|ending| ending != "md") {
            ("the report is Markdown", file.display().to_string(), "a file that ends in .md")
        } else if cases != 1 {
            ("a report is of one case", format!("{}, {cases} cases", file.display()), "the folder of one case")
        } else {
            return Ok(());
        };
        Err(Input::new(what).key("--bug").found(found).expected(expected).into())
    }

    /// The report of a case that ended so.
    fn report(&self, (folder, case): (&Path, &Case), ended: &bug::Ended, adapter: &Adapter) -> Result<String> {
        let layer = Instance::open(!self.device.no_validation)?.layer();
        // A kernel that ended a process may end this one.
        let device = ended.is_ok().then(|| self.device.open()).transpose()?;
        let mut command =
            format!("milkglass replay {} --device {}", quoted(&folder.display().to_string()), adapter.number);
        command += if self.device.no_validation { " --no-validation" } else { "" };
        command += &format!(" --times {}{}", self.times, self.replace.again());
        let replaced = self.replace.told();
        bug::report((folder, case), ended, adapter, (layer.as_deref(), device.as_ref()), (&command, &replaced))
    }
}

/// What a process that runs a case says.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Said {
    /// The device is open.
    Opened,
    /// The case has been run.
    Found(Found),
}

/// Replays the cases; fails if one of them is beyond tolerance, or does not end.
pub fn run(arguments: &Arguments) -> Result<()> {
    let kernels = arguments.replace.load()?;
    let mut cases = Vec::new();
    for folder in folders(&arguments.folder)? {
        let mut case = Case::read(&folder)?;
        if let Some(fault) = arguments.replace.unused(&case.kernels(), "this case") {
            return Err(fault.into());
        }
        for (kernel, words) in &kernels {
            case = case.replacing(kernel, words)?;
        }
        cases.push((folder, case));
    }
    if arguments.child {
        let device = (!arguments.device.interprets()).then(|| arguments.device.open()).transpose()?;
        say(&Said::Opened)?;
        return cases.iter().try_for_each(|(_, case)| {
            let found = device.as_ref().map(|device| case.replay(device, arguments.times as usize));
            say(&Said::Found(found.unwrap_or_else(|| case.interpreted())?))
        });
    }
    ready([("--bug", arguments.bug.as_ref())])?;
    arguments.report_is_sound(cases.len())?;
    let adapter = arguments.device.look()?;
    let number = if arguments.device.interprets() { DEVICE.into() } else { adapter.number.to_string() };
    let mut words = vec!["--device".to_string(), number];
    words.extend(arguments.device.no_validation.then(|| "--no-validation".to_string()));
    words.extend(arguments.replace.words().map(str::to_string));
    let (mut rows, mut failed) = (Vec::new(), 0);
    for (folder, case) in &cases {
        let two = case.about.seconds.unwrap_or(600.0);
        let timeout = arguments.timeout.unwrap_or(two * f64::from(arguments.times.max(2)) / 2.0);
        let ended = played(folder, &words, (arguments.times, timeout))?;
        let (cells, verdict) = tell(folder, &ended);
        if let Some(file) = &arguments.bug {
            write(file, arguments.report((folder, case), &ended, &adapter)?)?;
        }
        failed += usize::from(verdict != "passes");
        let row = [folder.display().to_string(), case.about.stage.clone(), case.dispatches.len().to_string()];
        rows.push(row.into_iter().chain(cells).chain([verdict.to_string()]).collect());
    }
    let header = ["case", "stage", "dispatches", "words", "wrong", "verdict"];
    print(&format!("{}, {}\n{}", adapter.name, adapter.driver, table(header, rows)))?;
    match failed {
        0 => Ok(()),
        1 => Err(Error::Check("1 case fails on this device".into())),
        more => Err(Error::Check(format!("{more} cases fail on this device"))),
    }
}

/// Says what is wrong with a case; returns the numbers of words that were compared and that are wrong, and the verdict.
fn tell(folder: &Path, ended: &bug::Ended) -> ([String; 2], &'static str) {
    match ended {
        Ok(found) => {
            for (_, count, first) in &found.wrong {
                tell!("{}: {count} words beyond tolerance: {first}", folder.display());
            }
            for message in &found.messages {
                tell!("{}: {message}", folder.display());
            }
            let wrong: usize = found.wrong.iter().map(|(_, count, _)| count).sum();
            ([found.words, wrong].map(|count| count.to_string()), if found.passes() { "passes" } else { "FAILS" })
        }
        Err((verdict, why)) => {
            tell!("{}: {why}", folder.display());
            (["-", "-"].map(str::to_string), verdict.name())
        }
    }
}

/// Tells the process that has started this one.
fn say(said: &Said) -> Result<()> {
    let text = serde_json::to_string(said).map_err(|error| Input::new(format!("could not be written: {error}")))?;
    print(&format!("{text}\n"))
}

/// Runs a case `times` times in a process of its own, with `words` as further arguments, for at most `timeout` seconds;
/// returns what it found, or why the process did not end well.
pub(super) fn played(
    folder: &Path,
    words: &[String],
    (times, timeout): (u32, f64),
) -> Result<std::result::Result<Found, (Verdict, String)>> {
    let mut child = itself("replay")?;
    child.arg(folder).args(["--times", &times.to_string()]).args(words);
    let (mut opened, mut found) = (false, None);
    let ended = watched(child, timeout, &mut |said: Said| {
        match said {
            Said::Opened => opened = true,
            Said::Found(own) => found = Some(own),
        }
        Ok(())
    })?;
    match (ended, found) {
        (Some((Verdict::DeviceFailed, why)), _) if !opened => Err(Error::device("opening the device", why)),
        (Some(ended), _) => Ok(Err(ended)),
        (None, Some(found)) => Ok(Ok(found)),
        (None, None) => Ok(Err((Verdict::Crashed, "it ended without a result".into()))),
    }
}

/// The folder itself if it is a case, else the cases in it.
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
pub(super) fn describe(folder: &Path, case: &Case) -> String {
    let about = &case.about;
    let kernels: Vec<String> = case.kernels().into_iter().collect();
    let fails = match (about.fails, about.seconds) {
        (true, Some(_)) => "does not end well",
        (true, None) => "fails",
        (false, _) => "conforms",
    };
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

/// The number of groups and bytes of a case, in words.
pub(super) fn amount(case: &Case) -> String {
    let groups = case.groups();
    format!("{groups} group{}, {}", if groups == 1 { "" } else { "s" }, size(case.bytes() as u64))
}
