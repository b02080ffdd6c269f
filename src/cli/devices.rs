//! `milkglass devices`: lists what a command can run on.

use clap::Args;

use super::device::opened;
use super::{print, size, table};
use milkglass::error::{Error, Result};
use milkglass::internals::gpu::{Adapter, Instance, Limits};
use milkglass::measure::probe::probe;
use milkglass::measure::table::Table;

/// Arguments of `devices`.
#[derive(Args)]
#[command(after_help = "Example: milkglass devices\n         milkglass devices --probe")]
pub struct Arguments {
    /// Run small kernels with exact answers on each device: they test what kernels rely on, and known faults of
    /// drivers.
    #[arg(long)]
    probe: bool,
}

/// Runs the probes on every usable device; fails if a device lacks what kernels rely on.
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
    print(&format!("\n{}", table(["device", "probe", "what it shows", "kernels", "found"], rows)))?;
    match lacking {
        0 => Ok(()),
        1 => Err(Error::Check("1 probe that kernels rely on fails".into())),
        more => Err(Error::Check(format!("{more} probes that kernels rely on fail"))),
    }
}

/// Prints every Vulkan device and the CPU back end.
pub fn run(arguments: &Arguments) -> Result<()> {
    // The first one is the CPU, which has no adapter.
    let mut rows = vec![None];
    match Instance::open(false).and_then(|instance| instance.adapters()) {
        Ok(adapters) => rows.extend(adapters.into_iter().map(Some)),
        Err(error) => tell!("{error}"),
    }
    print(&listed(&rows).text())?;
    if arguments.probe { probes() } else { Ok(()) }
}

fn listed(rows: &[Option<Adapter>]) -> Table {
    let cell = |row: &Option<Adapter>, text: &dyn Fn(&Adapter) -> String| row.as_ref().map_or_else(|| "-".into(), text);
    let name = |adapter: &Adapter| format!("{} ({})", adapter.name, adapter.kind);
    let state = |adapter: &Adapter| adapter.unusable.clone().unwrap_or_else(|| "usable".into());
    let rounding = |limits: Limits| if limits.round_to_nearest { "to nearest" } else { "not offered" };
    Table::of(
        rows,
        &[
            ("device", "", &|row| row.as_ref().map_or_else(|| "cpu".into(), |adapter| adapter.number.to_string())),
            ("name", "", &|row| row.as_ref().map_or_else(|| "CPU reference (f64)".into(), name)),
            ("driver", "", &|row| cell(row, &|adapter| adapter.driver.clone())),
            ("Vulkan", "", &|row| cell(row, &|adapter| adapter.version.clone())),
            ("state", "", &|row| row.as_ref().map_or_else(|| "usable".into(), state)),
            ("binding", "", &|row| cell(row, &|adapter| size(adapter.limits.binding_bytes))),
            ("allocation", "", &|row| cell(row, &|adapter| size(adapter.limits.allocation_bytes))),
            ("buffers", "", &|row| cell(row, &|adapter| adapter.limits.storage_buffers.to_string())),
            ("push", "", &|row| cell(row, &|adapter| format!("{} B", adapter.limits.push_bytes))),
            ("group", "", &|row| cell(row, &|adapter| adapter.limits.group_invocations.to_string())),
            ("subgroup", "", &|row| cell(row, &|adapter| adapter.limits.subgroup_size.to_string())),
            ("rounding", "", &|row| cell(row, &|adapter| rounding(adapter.limits).into())),
        ],
    )
}
