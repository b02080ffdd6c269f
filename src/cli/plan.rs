//! `milkglass plan`: shows what a scene needs, without running it.

mod diff;

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use super::long_work::{json_of, of_plan};
use super::{RunArguments, SceneArguments, flow, open_session, print, size, table, validation, write};
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::constants;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::about_mode;
use milkglass::internals::pipeline::buffer_sizes::grows;
use milkglass::internals::pipeline::frame::precedes_transport;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::requirements::{KernelRequirements, StageRequirements};
use milkglass::internals::session::run::Session;
use milkglass::internals::session::workload::Workload;
use milkglass::internals::state::{Extent, Stage};
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

/// A frame from scratch whose picture is shown.
const WHOLE: Change = Change { relink: true, tone: true, ..Change::EVERYTHING };
/// What the error estimate lacks where light casts shadows and `transport.subdivide` is 0.
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
    let page = Page::new(&session)?;
    let stages = page.stages();
    print(&page.text(device.as_ref().map_or("cpu", |device| device.name()), &stages)?)?;
    if let Some(path) = &arguments.flow {
        flow::write(path, &|name| stages.iter().any(|row| row[0] == name))?;
    }
    if let Some(path) = &arguments.json {
        write(path, format!("{:#}\n", page.json(&stages)?))?;
    }
    Ok(())
}

/// What is told of a session's frame.
struct Page<'a> {
    session: &'a Session,
    needs: Vec<StageRequirements>,
    load: Workload,
    /// The session of the error estimate, if it is another one.
    sharper: Option<Session>,
    /// Buffers that are larger than the device binds.
    misfits: BTreeSet<BufferId>,
}

impl<'a> Page<'a> {
    fn new(session: &'a Session) -> Result<Self> {
        let (needs, load) = (session.needs(WHOLE)?, session.workload());
        Ok(Self { session, needs, load, sharper: session.sharper()?, misfits: session.misfits(WHOLE)? })
    }

    /// So many things of all objects.
    fn count(&self, things: fn(&Extent) -> usize) -> usize {
        self.session.state().sum(|object| things(&object.count))
    }

    /// The whole page.
    fn text(&self, device: &str, stages: &[Vec<String>]) -> Result<String> {
        let mut text = self.head(device);
        text += "\n\nstages\n";
        text += &table(["stage", "does", "from", "writes"], stages.to_vec());
        text += "\nwork: of a frame from scratch; bytes bound, each once\n";
        text += &work(&self.needs);
        text += &of_plan(&self.load);
        if let Some(other) = &self.sharper {
            let (tolerance, bytes) = (other.scene().transport.tolerance, size(total(other)));
            text += &format!(
                "\nerror estimate: light is carried once more, at tolerance {tolerance}, in another {bytes} while that \
                 lasts\n{}",
                work(&other.needs(WHOLE)?)
            );
        }
        if self.session.leaves_out_borders() {
            text += BORDERS;
        }
        let mut kernels = Vec::new();
        for need in self.needs.iter().flat_map(|need| &need.kernels) {
            kernels.push(vec![need.name.clone(), need.dispatches.to_string(), need.specialized()?]);
        }
        text += "\nkernels: a pipeline each\n";
        text += &table(["kernel", "dispatches", "specialization constants"], kernels);
        text += "\nbuffers\n";
        text += &table(["buffer", "one per", "elements", "size", ""], self.buffers());
        text += "\nleft out\n";
        let left = self.session.plan().left_out.iter().map(|(what, why)| vec![what.to_string(), why.clone()]);
        Ok(text + &table(["stage", "because"], left.collect()))
    }

    /// What the scene is, and how its frame is run.
    fn head(&self, device: &str) -> String {
        let (session, state) = (self.session, self.session.state());
        let trees = session.rebuilt();
        let trees: String = trees.iter().chain(session.maps()).map(|line| format!("\n{line}")).collect();
        format!(
            "{}: {}{} triangles, {} vertices, {} nodes, {} chunks of links, {} lights, on {device}\nmode {}{trees}",
            session.scene().name,
            if state.objects.len() > 1 { format!("{} objects, ", state.objects.len()) } else { String::new() },
            self.count(|count| count.faces),
            self.count(|count| count.vertices),
            self.count(|count| count.nodes),
            state.sum(|object| object.schedule.chunks.len()),
            state.data.object_params[0].lights,
            about_mode(state, session.plan().options()),
        )
    }

    /// Each stage: its name, what it does, where that comes from, and the buffers that it writes.
    fn stages(&self) -> Vec<Vec<String>> {
        let (state, plan) = (self.session.state(), self.session.plan());
        let row = |stage: &&Stage| {
            let writes: Vec<_> = stage.writes.iter().map(|(slot, _, _)| slot.spec().name).collect();
            vec![stage.name.to_string(), stage.about.to_string(), stage.equation.to_string(), writes.join(" ")]
        };
        let mut stages: Vec<Vec<String>> = plan.stages.iter().map(row).collect();
        if plan.runs_on_host(&HOST, state, Change::EVERYTHING) {
            let place = plan.stages.iter().position(|stage| !precedes_transport(stage)).unwrap_or(stages.len());
            let host = [HOST.name, HOST.about, HOST.equation, HOST.writes.spec().name];
            stages.insert(place, host.map(String::from).to_vec());
        }
        stages
    }

    /// Each buffer with its size, and their sum.
    fn buffers(&self) -> Vec<Vec<String>> {
        let row = |(slot, bytes): (BufferId, u64)| {
            let spec = slot.spec();
            // Lists start at a guess and grow to what a frame needs.
            let note = match (self.misfits.contains(&slot), grows(slot)) {
                (true, _) => "more than the device binds: use fewer triangles or pixels, or --device cpu",
                (false, true) => "grows as needed",
                (false, false) => "",
            };
            let count = (bytes / spec.stride as u64).to_string();
            vec![spec.name.to_string(), spec.per.to_string(), count, size(bytes), note.to_string()]
        };
        let sum = ["total".into(), String::new(), String::new(), size(total(self.session)), String::new()];
        self.session.buffers().into_iter().map(row).chain([sum.to_vec()]).collect()
    }

    /// The same page as JSON.
    fn json(&self, stages: &[Vec<String>]) -> Result<Value> {
        let (session, state, plan) = (self.session, self.session.state(), self.session.plan());
        let estimate = |other: &Session| -> Result<Value> {
            let stage = |need: &StageRequirements| json!({"stage": need.stage, "dispatches": need.dispatches});
            let stages: Vec<_> = other.needs(WHOLE)?.iter().map(stage).collect();
            Ok(json!({"tolerance": other.scene().transport.tolerance, "bytes": total(other), "stages": stages}))
        };
        Ok(json!({
            "scene": session.scene().name,
            "triangles": self.count(|count| count.faces),
            "vertices": self.count(|count| count.vertices),
            "nodes": self.count(|count| count.nodes),
            "objects": state.objects.len(),
            "mode": about_mode(state, plan.options()),
            "trees": session.rebuilt(),
            "maps": session.maps(),
            "too_large": self.misfits.iter().map(|slot| slot.spec().name).collect::<Vec<_>>(),
            "chunks": state.sum(|object| object.schedule.chunks.len()),
            "stages": stages.iter().map(|row| stage_json(row, &self.needs)).collect::<Vec<_>>(),
            "buffers": session.buffers().iter()
                .map(|(slot, bytes)| json!({"buffer": slot.spec().name, "per": slot.spec().per, "bytes": bytes}))
                .collect::<Vec<_>>(),
            "rays": json_of(&self.load),
            // A separate solve.
            "error_estimate": self.sharper.as_ref().map(estimate).transpose()?,
            "estimate_leaves_out_borders": session.leaves_out_borders(),
            "left_out": plan.left_out.iter().map(|(what, why)| json!({"stage": what, "because": why}))
                .collect::<Vec<_>>(),
        }))
    }
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
