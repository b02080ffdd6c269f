//! Sections on the setting: the devices, and the stages and buffers of each built-in scene.

use super::{Bench, Page};
use crate::error::Result;
use crate::gpu::{Adapter, Device, Instance};
use crate::layout::BUFFER_IDS;
use crate::measure::table::Table;
use crate::pipeline::plan::Options;
use crate::scene::{BUILTIN, Scene};
use crate::session::run::Session;

/// The environment of the report, for the top of the page.
pub fn about(bench: &Bench<'_>) -> Vec<(&'static str, String)> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    vec![
        ("device", bench.device.map_or("cpu", Device::name).to_string()),
        ("driver", bench.device.map_or("none: the f64 reference on the host", Device::driver).to_string()),
        ("host", format!("{} {}, {cores} cores", std::env::consts::OS, std::env::consts::ARCH)),
        ("milkglass", env!("CARGO_PKG_VERSION").to_string()),
        ("extent", bench.either("quick: small scenes, few settings", "full").to_string()),
    ]
}

/// Lists all Vulkan devices with the relevant limits.
pub fn devices(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let adapters = match Instance::open(false).and_then(|instance| instance.adapters()) {
        Ok(adapters) => adapters,
        Err(error) => {
            page.say(&format!("No Vulkan here: {error}."));
            return Ok(());
        }
    };
    let state = |adapter: &Adapter| {
        let used = bench.device.is_some_and(|device| device.name() == adapter.name);
        adapter.unusable.clone().unwrap_or_else(|| if used { "used" } else { "usable" }.into())
    };
    let table = Table::of(
        &adapters,
        &[
            ("name", "", &|a| a.name.clone()),
            ("kind", "", &|a| a.kind.into()),
            ("driver", "", &|a| a.driver.clone()),
            ("Vulkan", "version that the device offers", &|a| a.version.clone()),
            ("state", "whether this report used it, or why it cannot be used", &state),
            ("binding, MiB", "largest range of a storage buffer that a kernel can bind", &|a| {
                (a.limits.binding_bytes >> 20).to_string()
            }),
            ("allocation, MiB", "largest single allocation", &|a| (a.limits.allocation_bytes >> 20).to_string()),
            ("buffers", "storage buffers that a kernel can bind", &|a| a.limits.storage_buffers.to_string()),
            ("push, B", "bytes of push constants", &|a| a.limits.push_bytes.to_string()),
            ("group", "largest workgroup, invocations", &|a| a.limits.group_invocations.to_string()),
            ("subgroup", "invocations in a subgroup", &|a| a.limits.subgroup_size.to_string()),
            (
                "rounding",
                "whether rounding to nearest can be requested; otherwise decisions rely on the driver's default",
                &|a| if a.limits.round_to_nearest { "to nearest" } else { "not offered" }.into(),
            ),
        ],
    );
    page.table("devices", &table)
}

/// The stages and buffers of each built-in scene, and what its plan leaves out.
pub fn plans(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say("What a scene does not use costs nothing: no pipeline, no buffer, no dispatch. Lists grow with the first frame.");
    let mut rows = Vec::new();
    let mut reasons = Vec::new();
    for (name, ..) in BUILTIN {
        let scene = Scene::load_with(name, &[])?;
        let session = Session::new(&scene, bench.device, Options::default())?;
        let (state, plan) = (session.state(), session.plan());
        let bytes: usize = BUFFER_IDS.iter().map(|slot| state.data.bytes(*slot).len()).sum();
        let buffers = BUFFER_IDS.iter().filter(|slot| !state.data.bytes(**slot).is_empty()).count();
        let stages: Vec<_> = plan.stages.iter().map(|stage| stage.name).collect();
        rows.push(vec![
            (*name).to_string(),
            state.sum(|object| object.count.faces).to_string(),
            state.objects.len().to_string(),
            stages.len().to_string(),
            buffers.to_string(),
            format!("{:.1}", bytes as f64 / 1_048_576.0),
            plan.left_out.len().to_string(),
            stages.join(" "),
        ]);
        reasons.extend(plan.left_out.iter().map(|(what, why)| vec![(*name).into(), (*what).into(), why.clone()]));
    }
    let columns = [
        ("scene", ""),
        ("triangles", ""),
        ("objects", ""),
        ("stages", "stages that a frame of the scene runs"),
        ("buffers", "buffers that are not empty"),
        ("MiB", "their size before the first frame, whose lists may grow"),
        ("left out", "stages and buffers that the scene does not need"),
        ("the stages", "in the order of the frame"),
    ];
    page.table("plan", &Table::new(columns, rows))?;
    let reasons = Table::plain(["scene", "left out", "because"], reasons);
    page.fold("What is left out, and why", |page| page.table("left-out", &reasons))
}
