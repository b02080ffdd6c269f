//! The process that compiles.

use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::arguments::Arguments;
use super::pipelines::Wanted;
use super::record::Pipeline;
use crate::cli::replace::replaced;
use crate::cli::write;
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Device, Instance, Kernel, Kernels};

/// In the folder of a child: the pipelines to compile, as JSON.
pub(super) const LIST: &str = "pipelines.json";
/// There: the module that is compiled next.
pub(super) const MODULE: &str = "module.spv";

/// What a child writes.
#[derive(Serialize, Deserialize)]
pub(super) enum Line {
    /// The device's name, and the driver's.
    Device(String),
    /// The kernel that is compiled next.
    Begins(String),
    Pipeline(Pipeline),
    /// The built-in kernel that another one replaces.
    BuiltIn(Pipeline),
}

/// Creates the pipelines on this process's device, and ends it.
pub(super) fn compile(arguments: &Arguments) -> Result<()> {
    let instance = Instance::open(false)?;
    let adapters = instance.adapters()?;
    let family = arguments.families.last().map_or("here", String::as_str);
    let adapter = match family {
        "here" => arguments.run.device.among(&adapters)?,
        family => adapters.iter().find(|adapter| adapter.null).ok_or_else(|| {
            let fault = Input::new("there is no RADV that compiles for this family").key("--for").found(family);
            fault.expected("Mesa's driver radeon (Debian: mesa-vulkan-drivers), and a family it knows")
        })?,
    };
    let built_in = Device::compiler(&instance, adapter, arguments.isa.is_some())?;
    let device = replaced(&built_in, &arguments.replace.load()?)?;
    let list = std::fs::read(arguments.exchange.join(LIST)).unwrap_or_default();
    let wanted: Vec<Wanted> = serde_json::from_slice(&list)
        .map_err(|error| Input::new("not a list of pipelines").key("--exchange").found(error))?;
    let mut out = std::io::stdout().lock();
    let mut say = |line: &Line| -> Result<()> {
        let text = serde_json::to_string(line).unwrap_or_default();
        writeln!(out, "{text}").and_then(|()| out.flush()).map_err(|error| Error::device("writing a line", error))
    };
    say(&Line::Device(format!("{}, {}", adapter.name, adapter.driver)))?;
    let kernels = [Kernels::new(&device), Kernels::new(&built_in)];
    for one in &wanted {
        let module: Vec<u8> = device.words(&one.kernel)?.iter().flat_map(|word| word.to_le_bytes()).collect();
        write(&arguments.exchange.join(MODULE), module)?;
        say(&Line::Begins(one.kernel.clone()))?;
        let kernel = kernels[0].get(&one.kernel, &one.values)?;
        say(&Line::Pipeline(reported(one, &kernel)?))?;
        if let Some(folder) = &arguments.isa {
            code(&folder.join(family), one, &kernel)?;
        }
        if device.replaced().any(|name| name == one.kernel) {
            say(&Line::BuiltIn(reported(one, &*kernels[1].get(&one.kernel, &one.values)?)?))?;
        }
    }
    // Nothing is destroyed.
    std::process::exit(0)
}

/// What the compiler reports of a kernel.
fn reported(wanted: &Wanted, kernel: &Kernel) -> Result<Pipeline> {
    Ok(Pipeline {
        kernel: wanted.kernel.clone(),
        constants: wanted.constants.clone(),
        milliseconds: 1e3 * kernel.creation.as_secs_f64(),
        statistics: kernel.statistics()?.into_iter().map(|statistic| (statistic.name, statistic.value)).collect(),
    })
}

/// Writes the code of a pipeline into this folder. The name of the file has the kernel's, and the constants'.
fn code(folder: &Path, wanted: &Wanted, kernel: &Kernel) -> Result<()> {
    let constants: String = wanted.constants.chars().filter(|c| !c.is_whitespace()).collect();
    let dot = if constants.is_empty() { "" } else { "." };
    let name = format!("{}{dot}{constants}.txt", wanted.kernel.replace('/', "-"));
    let texts = kernel.code()?.into_iter().map(|(name, text)| format!("==== {name}\n{text}\n"));
    write(&folder.join(name), texts.collect::<String>())
}
