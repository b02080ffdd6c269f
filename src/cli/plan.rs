//! `milkglass plan`: shows what a scene needs, without running it.

mod diff;

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use super::long_work::{json_of, of_plan};
use super::{RunArguments, SceneArguments, flow, open_session, print, size, table, validation, write};
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::constants;
use milkglass::internals::pipeline::about_mode;
use milkglass::internals::pipeline::buffer_sizes::grows;
use milkglass::internals::pipeline::frame::precedes_transport;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::requirements::{KernelRequirements, StageRequirements};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Extent;
use milkglass::internals::transport::octree::HOST;
use milkglass::internals::view::atomic_file::ready;

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = "Example: milkglass plan lotus --mode render --json plan.json\n         \
                        milkglass plan lotus --set light.0.shadows=false --diff lotus")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    /// Also plan for layers, as `render --aov` writes them, with their error estimate.
    #[arg(long)]
    aov: bool,
    /// Show how another scene's needs differ. `--set` and other options apply to the first one only, except the
    /// device.
    #[arg(long, value_name = "OTHER_SCENE")]
    diff: Option<String>,
    /// Also write the plan to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also draw which buffers each stage reads and writes; what this scene does without is grey.
    #[arg(long, value_name = "FILE.svg")]
    flow: Option<PathBuf>,
}

/// The change before a frame from scratch whose picture is shown.
const WHOLE: Change = Change { relink: true, tone: true, ..Change::EVERYTHING };
/// What is told where the error estimate leaves out borders of shadows.
const BORDERS: &str =
    "\nerror estimate: without borders of shadows within triangles; transport.subdivide = 2 puts them in\n";

/// Prints stages, buffers, and what is skipped.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--json", arguments.json.as_ref()), ("--flow", arguments.flow.as_ref())])?;
    let scene = arguments.run.of(&arguments.scene).load()?;
    let device = arguments.run.device.open(validation())?;
    let mut options = arguments.run.options();
    if arguments.aov {
        options.carries("--aov")?;
        options = options.with_layers();
    }
    let session = open_session(&scene, device.as_ref(), options)?;
    if let Some(other) = &arguments.diff {
        if arguments.json.is_some() {
            let fault = Input::new("a difference has no JSON").key("--json").found("--diff");
            return Err(fault.expected("one of the two").into());
        }
        let scene = arguments.scene.other(other)?;
        let against = open_session(&scene, device.as_ref(), Options::default())?;
        return print(&diff::text(&session, &against)?);
    }
    let needs = session.needs(WHOLE)?;
    let (state, plan) = (session.state(), session.plan());

    let frame = &state.data.object_params[0];
    let count = |of: fn(&Extent) -> usize| state.sum(|object| of(&object.count));
    let mut text = format!(
        "{}: {}{} triangles, {} vertices, {} nodes, {} chunks of links, {} lights, on {}\n\nstages\n",
        scene.name,
        if state.objects.len() > 1 { format!("{} objects, ", state.objects.len()) } else { String::new() },
        count(|count| count.faces),
        count(|count| count.vertices),
        count(|count| count.nodes),
        state.sum(|object| object.schedule.chunks.len()),
        frame.lights,
        device.as_ref().map_or("cpu", |device| device.name()),
    );
    let mode = about_mode(state, plan.options());
    let rebuilt = session.rebuilt();
    let trees: String = rebuilt.iter().chain(session.maps()).map(|line| format!("\n{line}")).collect();
    text = text.replacen("\n\nstages", &format!("\nmode {mode}{trees}\n\nstages"), 1);
    let mut stages: Vec<Vec<String>> = plan
        .stages
        .iter()
        .map(|stage| {
            let writes: Vec<_> = stage.writes.iter().map(|(slot, _, _)| slot.spec().name).collect();
            vec![stage.name.to_string(), stage.about.to_string(), stage.equation.to_string(), writes.join(" ")]
        })
        .collect();
    if plan.runs_on_host(&HOST, state, Change::EVERYTHING) {
        let place = plan.stages.iter().position(|stage| !precedes_transport(stage)).unwrap_or(stages.len());
        stages
            .insert(place, [HOST.name, HOST.about, HOST.equation, HOST.writes.spec().name].map(String::from).to_vec());
    }
    text += &table(["stage", "does", "from", "writes"], stages.clone());
    text += "\nwork: of a frame from scratch; bytes bound, each once\n";
    text += &work(&needs);
    let load = session.workload();
    text += &of_plan(&load);
    let sharper = session.sharper()?;
    if let Some(other) = &sharper {
        let (tolerance, bytes) = (other.scene().transport.tolerance, total(other));
        let needs = other.needs(WHOLE)?;
        text += &format!(
            "\nerror estimate: light is carried once more, at tolerance {tolerance}, in another {} while that lasts\n{}",
            size(bytes),
            work(&needs)
        );
    }
    if session.leaves_out_borders() {
        text += BORDERS;
    }
    let mut kernels = Vec::new();
    for need in needs.iter().flat_map(|need| &need.kernels) {
        kernels.push(vec![need.name.clone(), need.dispatches.to_string(), need.specialized()?]);
    }
    text += "\nkernels: a pipeline each\n";
    text += &table(["kernel", "dispatches", "specialization constants"], kernels);

    // Lists start at a guess and grow to what a frame needs.
    let misfits = session.misfits(WHOLE)?;
    let mut buffers = Vec::new();
    for (slot, bytes) in session.buffers() {
        let spec = slot.spec();
        let note = match (misfits.contains(&slot), grows(slot)) {
            (true, _) => "more than the device binds: use fewer triangles or pixels, or --device cpu",
            (false, true) => "grows as needed",
            (false, false) => "",
        };
        let count = (bytes / spec.stride as u64).to_string();
        buffers.push(vec![spec.name.to_string(), spec.per.to_string(), count, size(bytes), note.to_string()]);
    }
    buffers.push(vec!["total".into(), String::new(), String::new(), size(total(&session)), String::new()]);
    text += "\nbuffers\n";
    text += &table(["buffer", "one per", "elements", "size", ""], buffers);
    text += "\nleft out\n";
    let left: Vec<_> = plan.left_out.iter().map(|(what, why)| vec![what.to_string(), why.clone()]).collect();
    text += &table(["stage", "because"], left);
    print(&text)?;

    if let Some(path) = &arguments.flow {
        flow::write(path, &|name| stages.iter().any(|row| row[0] == name))?;
    }
    if let Some(path) = &arguments.json {
        let value = json!({
            "scene": scene.name,
            "triangles": count(|count| count.faces),
            "vertices": count(|count| count.vertices),
            "nodes": count(|count| count.nodes),
            "objects": state.objects.len(),
            "mode": mode,
            "trees": rebuilt,
            "maps": session.maps(),
            "too_large": misfits.iter().map(|slot| slot.spec().name).collect::<Vec<_>>(),
            "chunks": state.sum(|object| object.schedule.chunks.len()),
            "stages": stages.iter().map(|row| stage_json(row, &needs)).collect::<Vec<_>>(),
            "buffers": session.buffers().iter()
                .map(|(slot, bytes)| json!({"buffer": slot.spec().name, "per": slot.spec().per, "bytes": bytes}))
                .collect::<Vec<_>>(),
            "rays": json_of(&load),
            // A separate solve.
            "error_estimate": sharper.as_ref().map(|other| -> Result<Value> {
                let stage = |need: &StageRequirements| json!({"stage": need.stage, "dispatches": need.dispatches});
                let stages: Vec<_> = other.needs(WHOLE)?.iter().map(stage).collect();
                Ok(json!({"tolerance": other.scene().transport.tolerance, "bytes": total(other), "stages": stages}))
            }).transpose()?,
            "estimate_leaves_out_borders": session.leaves_out_borders(),
            "left_out": plan.left_out.iter().map(|(what, why)| json!({"stage": what, "because": why}))
                .collect::<Vec<_>>(),
        });
        write(path, format!("{value:#}\n"))?;
    }
    Ok(())
}

/// Steps, dispatches and bytes of each stage.
fn work(needs: &[StageRequirements]) -> String {
    let row = |need: &StageRequirements| {
        let [read, written] = need.bytes.map(size);
        vec![need.stage.to_string(), need.steps.to_string(), need.dispatches.to_string(), read, written]
    };
    let rows: Vec<_> = needs.iter().map(row).collect();
    table(["stage", "steps", "dispatches", "to read", "to write"], rows)
}

/// Bytes of all buffers.
fn total(session: &Session) -> u64 {
    session.buffers().iter().map(|(_, bytes)| bytes).sum()
}

/// A stage of the table, with its requirements.
fn stage_json(row: &[String], needs: &[StageRequirements]) -> Value {
    let Some(need) = needs.iter().find(|need| need.stage == row[0]) else {
        return json!({"stage": row[0], "does": row[1]});
    };
    let kernel = |kernel: &KernelRequirements| {
        let names = constants(&kernel.name).unwrap_or_default().into_iter();
        let constants: serde_json::Map<_, _> = names.zip(kernel.constants.iter().map(|value| json!(value))).collect();
        json!({"kernel": kernel.name, "dispatches": kernel.dispatches, "constants": constants})
    };
    json!({"stage": row[0], "does": row[1], "steps": need.steps, "dispatches": need.dispatches,
           "bytes_read": need.bytes[0], "bytes_written": need.bytes[1],
           "kernels": need.kernels.iter().map(kernel).collect::<Vec<_>>()})
}
