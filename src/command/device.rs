//! The device that a command runs on.

use clap::Args;

use crate::error::{Error, Result};
use crate::gpu::{Adapter, Device, Instance};

/// Where to run.
#[derive(Args)]
pub(super) struct DeviceArgument {
    /// `cpu`, a device's number in `milkglass devices`, or a part of its name [default: the best Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
}

impl DeviceArgument {
    /// The device asked for, or the best; `None` is the CPU.
    pub(super) fn open(&self, validation: bool) -> Result<Option<Device>> {
        let wish = self.device.as_deref();
        if wish.is_some_and(|wish| wish.eq_ignore_ascii_case("cpu")) {
            return Ok(None);
        }
        let found = Instance::open(validation).and_then(|instance| Ok((instance.adapters()?, instance)));
        match (wish, found) {
            (None, Ok((adapters, instance))) => match Adapter::best(&adapters) {
                Some(adapter) => Device::open(&instance, adapter).map(Some),
                None => {
                    eprintln!("no usable Vulkan device: running on the CPU");
                    Ok(None)
                }
            },
            (None, Err(error)) if !validation => {
                eprintln!("running on the CPU: {error}");
                Ok(None)
            }
            (_, Err(error)) => Err(error),
            (Some(wish), Ok((adapters, instance))) => Device::open(&instance, pick(&adapters, wish)?).map(Some),
        }
    }
}

/// The adapter of this number, or the first whose name contains this text.
pub(super) fn pick<'a>(adapters: &'a [Adapter], wish: &str) -> Result<&'a Adapter> {
    let low = wish.to_lowercase();
    let by_number = wish.parse::<usize>().ok().and_then(|index| adapters.get(index));
    by_number.or_else(|| adapters.iter().find(|a| !low.is_empty() && a.name.to_lowercase().contains(&low))).ok_or_else(
        || {
            let names: Vec<_> = adapters.iter().enumerate().map(|(i, a)| format!("{i} ({})", a.name)).collect();
            let known = if names.is_empty() { "no Vulkan device is installed".to_string() } else { names.join(", ") };
            Error::device(format!("looking for device {wish:?}"), format!("there is none; there are cpu, {known}"))
        },
    )
}
