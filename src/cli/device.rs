//! The device that a command runs on.

use std::time::Duration;

use clap::Args;

use milkglass::error::{Error, Input, Result};
use milkglass::gpu::{Adapter, Device, Instance};

/// The device argument.
#[derive(Args)]
pub(super) struct DeviceArgument {
    /// `cpu`, a device's number in `milkglass devices`, or part of its name [default: the best Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
}

impl DeviceArgument {
    /// Opens the requested device, or the best one; `None` is the CPU.
    pub(super) fn open(&self, validation: bool) -> Result<Option<Device>> {
        let wish = self.device.as_deref();
        if wish.is_some_and(|wish| wish.eq_ignore_ascii_case("cpu")) {
            return Ok(None);
        }
        let found = Instance::open(validation).and_then(|instance| Ok((instance.adapters()?, instance)));
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
            (Some(wish), Ok((adapters, instance))) => opened(&instance, pick(&adapters, wish)?).map(Some),
        }
    }
}

/// Opens an adapter, with the timeout that the environment variable MILKGLASS_TIMEOUT sets.
pub(super) fn opened(instance: &Instance, adapter: &Adapter) -> Result<Device> {
    let device = Device::open(instance, adapter)?;
    if let Some(text) = std::env::var_os("MILKGLASS_TIMEOUT") {
        let text = text.to_string_lossy();
        let seconds = text.parse().ok().filter(|seconds| (0.001..=1e6).contains(seconds));
        let fault = || Input::new("not a time").key("MILKGLASS_TIMEOUT").found(&text).expected("0.001 to 1e6 seconds");
        device.wait_at_most(Duration::from_secs_f64(seconds.ok_or_else(fault)?));
    }
    Ok(device)
}

/// The adapter with this number or name, or the only one whose name contains this text.
pub(super) fn pick<'a>(adapters: &'a [Adapter], wish: &str) -> Result<&'a Adapter> {
    let low = wish.to_lowercase();
    let named = |fits: &dyn Fn(&str) -> bool| {
        let fitting = |adapter: &&Adapter| !low.is_empty() && fits(&adapter.name.to_lowercase());
        adapters.iter().filter(fitting).collect::<Vec<_>>()
    };
    let whole = named(&|name| name == low);
    let found = if whole.is_empty() { named(&|name| name.contains(&low)) } else { whole };
    let by_number = wish.parse::<usize>().ok().and_then(|index| adapters.get(index));
    let names: Vec<_> = adapters.iter().enumerate().map(|(i, a)| format!("{i} ({})", a.name)).collect();
    let known = if names.is_empty() { "no Vulkan device is installed".to_string() } else { names.join(", ") };
    let what = match (by_number, found.as_slice()) {
        (Some(adapter), _) => return Ok(adapter),
        (None, &[adapter]) => return Ok(adapter),
        (None, []) => format!("there is none; there are cpu, {known}"),
        (None, several) => format!("{} devices have that in their names, give a number: {known}", several.len()),
    };
    Err(Error::device(format!("looking for device {wish:?}"), what))
}

#[cfg(test)]
mod tests {
    use crate::cli::device::*;

    #[test]
    fn devices_go_by_number_and_by_as_much_of_the_name_as_tells_them_apart() {
        let named = |name: &str| {
            let mut adapter = Adapter::default();
            adapter.name = name.into();
            adapter
        };
        let adapters = ["GeForce RTX 4090", "GeForce RTX 4090 Ti", "llvmpipe", "llvmpipe"].map(named);
        let at = |wish: &str| pick(&adapters, wish).map(|found| found as *const Adapter as usize);
        let place = |k: usize| &raw const adapters[k] as usize;
        for (wish, k) in [("0", 0), ("3", 3), ("ti", 1), ("geforce rtx 4090", 0), ("4090 TI", 1)] {
            assert_eq!(at(wish).unwrap(), place(k), "{wish}");
        }
        for (wish, words) in [("geforce", "2 devices"), ("llvmpipe", "give a number"), ("7", "there is none")] {
            let error = at(wish).unwrap_err();
            assert!(error.to_string().contains(words) && error.exit_code() == 3, "{wish}: {error}");
            assert!(error.to_string().contains("2 (llvmpipe)"), "{error}");
        }
        assert!(at("").is_err() && pick(&[], "x").unwrap_err().to_string().contains("no Vulkan device is installed"));
    }
}
