//! `milkglass plan`: what a scene needs, without running it.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::{RunArguments, SceneArguments, open_session, print, size, table, validation};
use crate::error::Result;
use crate::layout::SLOTS;
use crate::render::about_mode;
use crate::render::octree;
use crate::render::plan::{Change, before_transport};
use crate::state::Extent;
use crate::view::picture::write_whole;

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = "Example: milkglass plan lotus --mode render --json plan.json")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    /// Also write the plan to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Prints stages, buffers, and what is left out.
pub fn run(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    let device = arguments.run.device.open(validation())?;
    let session = open_session(&scene, device.as_ref(), arguments.run.options())?;
    let (state, plan) = (session.state(), &session.plan);

    let frame = &state.data.frame[0];
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
    text = text.replacen("\n\nstages", &format!("\nmode {mode}\n\nstages"), 1);
    let mut stages: Vec<_> = plan
        .stages
        .iter()
        .map(|stage| {
            let writes: Vec<_> = stage.writes.iter().map(|(slot, _, _)| slot.spec().name).collect();
            vec![stage.name.to_string(), stage.about.to_string(), stage.equation.to_string(), writes.join(" ")]
        })
        .collect();
    if plan.octree(Change::EVERYTHING) {
        let place = plan.stages.iter().position(|stage| !before_transport(stage.name)).unwrap_or(stages.len());
        stages.insert(place, [octree::NAME, octree::ABOUT, octree::EQUATION, "radiosity"].map(String::from).to_vec());
    }
    text += &table(&["stage", "does", "from", "writes"], &[], &stages);

    // Lists start with a guess and grow to what a frame turns out to need.
    let lists = ["handed", "links", "factors", "area_links", "edge_links"];
    let mut total = 0;
    let mut buffers = Vec::new();
    for slot in SLOTS {
        let (spec, bytes) = (slot.spec(), state.data.bytes(*slot).len() as u64);
        if bytes > 0 {
            total += bytes;
            let note = if lists.contains(&spec.name) { "grows as needed" } else { "" };
            let count = bytes / spec.stride as u64;
            buffers.push(vec![
                spec.name.to_string(),
                spec.per.to_string(),
                count.to_string(),
                size(bytes),
                note.to_string(),
            ]);
        }
    }
    buffers.push(vec!["total".into(), String::new(), String::new(), size(total), String::new()]);
    text += "\nbuffers\n";
    text += &table(&["buffer", "one per", "elements", "size", ""], &[2, 3], &buffers);
    text += "\nleft out\n";
    let left: Vec<_> = plan.left_out.iter().map(|(what, why)| vec![what.to_string(), why.clone()]).collect();
    text += &table(&["stage", "because"], &[], &left);
    print(&text)?;

    if let Some(path) = &arguments.json {
        let value = json!({
            "scene": scene.name,
            "triangles": count(|count| count.faces),
            "vertices": count(|count| count.vertices),
            "nodes": count(|count| count.nodes),
            "objects": state.objects.len(),
            "mode": mode,
            "chunks": state.sum(|object| object.schedule.chunks.len()),
            "stages": stages.iter().map(|row| json!({"stage": row[0], "does": row[1]})).collect::<Vec<_>>(),
            "buffers": SLOTS.iter().map(|slot| (slot.spec(), state.data.bytes(*slot).len()))
                .filter(|(_, bytes)| *bytes > 0)
                .map(|(spec, bytes)| json!({"buffer": spec.name, "per": spec.per, "bytes": bytes}))
                .collect::<Vec<_>>(),
            "left_out": plan.left_out.iter().map(|(what, why)| json!({"stage": what, "because": why}))
                .collect::<Vec<_>>(),
        });
        write_whole(path, |beside| std::fs::write(beside, format!("{value:#}\n")).map_err(|e| e.to_string()))?;
    }
    Ok(())
}
