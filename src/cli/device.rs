//! The device that a command runs on.

use std::time::Duration;

use clap::Args;

use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Adapter, Device, Instance};

/// The device argument.
#[derive(Args)]
pub(super) struct DeviceArgument {
    /// `cpu`, a device's number in `milkglass devices`, or part of its name [default: the best Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
}

impl DeviceArgument {
    /// The argument with this name; `None` for the best device.
    pub(super) fn named(device: Option<String>) -> Self {
        Self { device }
    }

    /// Opens the requested device, or the best one; `None` is the CPU.
    pub(super) fn open(&self, validation: bool) -> Result<Option<Device>> {
        if self.is_cpu() {
            return Ok(None);
        }
        self.open_among(Instance::open(validation), validation)
    }

    /// The adapter with this name, or the best one.
    pub(super) fn among<'a>(&self, adapters: &'a [Adapter]) -> Result<&'a Adapter> {
        match self.device.as_deref() {
            Some(wish) => Adapter::find(adapters, wish),
            None => Adapter::best(adapters)
                .ok_or_else(|| Error::device("finding a compiler", "there is no usable Vulkan device")),
        }
    }

    /// The argument as a word of a command line.
    pub(super) fn words(&self) -> Option<String> {
        self.device.as_ref().map(|device| format!("--device={device}"))
    }

    /// Whether the CPU is requested.
    pub(super) fn is_cpu(&self) -> bool {
        self.device.as_deref().is_some_and(|wish| wish.eq_ignore_ascii_case("cpu"))
    }

    /// Opens the requested device, or the best one, among those of this instance. Without a usable one, and with none
    /// requested, `None`: the CPU.
    pub(super) fn open_among(&self, instance: Result<Instance>, validation: bool) -> Result<Option<Device>> {
        let wish = self.device.as_deref();
        let found = instance.and_then(|instance| Ok((instance.adapters()?, instance)));
        match (wish, found) {
            (None, Ok((adapters, instance))) => match Adapter::best(&adapters) {
                Some(adapter) => opened(&instance, adapter).map(Some),
                None => {
                    let why = |a: &Adapter| format!("; {} {}", a.name, a.unusable.as_deref().unwrap_or_default());
                    let all: String = adapters.iter().map(why).collect();
                    tell!("no usable Vulkan device: running on the CPU{all}");
                    Ok(None)
                }
            },
            (None, Err(error)) if !validation => {
                tell!("running on the CPU: {error}");
                Ok(None)
            }
            (_, Err(error)) => Err(error),
            (Some(wish), Ok((adapters, instance))) => opened(&instance, Adapter::find(&adapters, wish)?).map(Some),
        }
    }
}

/// Opens an adapter, with the timeout that the environment variable MILKGLASS_TIMEOUT sets.
pub(super) fn opened(instance: &Instance, adapter: &Adapter) -> Result<Device> {
    let device = Device::open(instance, adapter)?;
    device.compile_ahead(true);
    if let Some(text) = std::env::var_os("MILKGLASS_TIMEOUT") {
        let text = text.to_string_lossy();
        let seconds = text.parse().ok().filter(|seconds| (0.001..=1e6).contains(seconds));
        let fault = || Input::new("not a time").key("MILKGLASS_TIMEOUT").found(&text).expected("0.001 to 1e6 seconds");
        device.wait_at_most(Duration::from_secs_f64(seconds.ok_or_else(fault)?));
    }
    Ok(device)
}

/// Whether the environment asks for the validation layer.
pub(super) fn validation() -> bool {
    std::env::var_os("MILKGLASS_VALIDATION").is_some_and(|value| value != "0")
}

/// Reports validation messages; any message is a failure.
pub(super) fn check_messages(device: Option<&Device>) -> Result<()> {
    let messages = device.map(Device::take_messages).unwrap_or_default();
    for message in &messages {
        tell!("{message}");
    }
    if messages.is_empty() {
        return Ok(());
    }
    Err(Error::Check(format!("the validation layer has {} messages", messages.len())))
}
