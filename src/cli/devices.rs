//! `milkglass devices`: lists what a command can run on.

use super::{print, size, table};
use milkglass::error::Result;
use milkglass::internals::gpu::{Adapter, Instance};

/// Prints every Vulkan device and the CPU back end.
pub fn run() -> Result<()> {
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
    Ok(())
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
