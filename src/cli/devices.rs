//! `milkglass devices`: lists what a command can run on.

use clap::Args;

use super::device::opened;
use super::{print, size, table};
use milkglass::error::{Error, Result};
use milkglass::internals::gpu::{Adapter, Instance};
use milkglass::measure::probe::probe;

/// Arguments of `devices`.
#[derive(Args)]
#[command(after_help = "Example: milkglass devices\n         milkglass devices --probe")]
pub struct Arguments {
    /// Run small kernels with exact answers on each device: what it gets right and wrong that kernels rely on, and
    /// known faults of drivers.
    #[arg(long)]
    probe: bool,
}

/// Runs the probes on every usable device; fails if one lacks what kernels rely on.
fn probes() -> Result<()> {
    let instance = Instance::open(super::validation())?;
    let (mut rows, mut lacking) = (Vec::new(), 0);
    for adapter in instance.adapters()?.iter().filter(|adapter| adapter.unusable.is_none()) {
        for fact in probe(&opened(&instance, adapter)?)? {
            lacking += usize::from(fact.needed && !fact.right);
            let needed = if fact.needed { "needed" } else { "avoided" };
            rows.push(vec![adapter.name.clone(), fact.name, fact.what, needed.into(), fact.found]);
        }
    }
    print(&format!("\n{}", table(&["device", "probe", "what it shows", "kernels", "found"], &[], &rows)))?;
    match lacking {
        0 => Ok(()),
        1 => Err(Error::Check("1 probe that kernels rely on fails".into())),
        more => Err(Error::Check(format!("{more} probes that kernels rely on fail"))),
    }
}

/// Prints every Vulkan device and the CPU back end.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut rows = vec![row("cpu", "CPU reference (f64)", "-", "-", "usable", None)];
    match Instance::open(false).and_then(|instance| instance.adapters()) {
        Ok(adapters) => {
            for (index, adapter) in adapters.iter().enumerate() {
                let state = adapter.unusable.clone().unwrap_or_else(|| "usable".to_string());
                let name = format!("{} ({})", adapter.name, adapter.kind);
                rows.push(row(&index.to_string(), &name, &adapter.driver, &adapter.version, &state, Some(adapter)));
            }
        }
        Err(error) => tell!("{error}"),
    }
    print(&table(
        &[
            "device",
            "name",
            "driver",
            "Vulkan",
            "state",
            "binding",
            "allocation",
            "buffers",
            "push",
            "group",
            "subgroup",
            "rounding",
        ],
        &[5, 6, 7, 8, 9, 10],
        &rows,
    ))?;
    if arguments.probe { probes() } else { Ok(()) }
}

fn row(index: &str, name: &str, driver: &str, version: &str, state: &str, adapter: Option<&Adapter>) -> Vec<String> {
    let limits = adapter.map(|adapter| adapter.limits);
    let show =
        |f: &dyn Fn(&milkglass::internals::gpu::Limits) -> String| limits.as_ref().map_or_else(|| "-".to_string(), f);
    vec![
        index.to_string(),
        name.to_string(),
        driver.to_string(),
        version.to_string(),
        state.to_string(),
        show(&|l| size(l.binding_bytes)),
        show(&|l| size(l.allocation_bytes)),
        show(&|l| l.storage_buffers.to_string()),
        show(&|l| format!("{} B", l.push_bytes)),
        show(&|l| l.group_invocations.to_string()),
        show(&|l| l.subgroup_size.to_string()),
        show(&|l| if l.round_to_nearest { "to nearest".into() } else { "not offered".into() }),
    ]
}
