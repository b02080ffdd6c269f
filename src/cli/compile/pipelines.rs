//! Which pipelines to compile: those of the plans of one scene, or of all built-in ones.

use std::collections::BTreeSet;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::arguments::Arguments;
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::kernel_names;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::{BUILTIN, Scene};

/// A pipeline to compile.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct Wanted {
    pub(super) kernel: String,
    /// The values of its specialization constants.
    pub(super) values: Vec<u32>,
    /// The same with their names.
    pub(super) constants: String,
}

/// The pipelines of a scene's plan.
pub(super) fn of_scene(scene: &Scene, options: Options) -> Result<Vec<Wanted>> {
    let (session, mut list) = (Session::new(scene, None, options)?, Vec::new());
    for stage in session.needs(Change { relink: true, tone: true, ..Change::EVERYTHING })? {
        for pipeline in &stage.kernels {
            let (kernel, values) = (pipeline.name.clone(), pipeline.constants.clone());
            list.push(Wanted { kernel, values, constants: pipeline.specialized()? });
        }
    }
    Ok(list)
}

/// The pipelines of the scene that is asked for, or with `--all` of all, each once.
pub(super) fn wanted(arguments: &Arguments) -> Result<Vec<Wanted>> {
    let (scene, options) = (arguments.run.of(&arguments.scene), arguments.run.options());
    let (mut known, mut list) = (BTreeSet::new(), Vec::new());
    let mut add = |scene: &Scene, options: Options| -> Result<()> {
        list.extend(of_scene(scene, options)?.into_iter().filter(|wanted| known.insert(wanted.clone())));
        Ok(())
    };
    if !arguments.all {
        if scene.scene.is_empty() {
            let fault = Input::new("no scene is given").key("SCENE");
            return Err(fault.expected("a scene, or --all").into());
        }
        add(&scene.load()?, options)?;
        return Ok(list);
    }
    for (name, ..) in BUILTIN {
        add(&Scene::load_with(name, &scene.sets)?, options)?;
    }
    for transport in ShadingMethod::value_variants() {
        let sets = ["object.0.detail=2", "transport.unwrap=true"].map(String::from);
        add(&Scene::load_with("sphere", &sets)?, Options { transport: *transport, ..options })?;
    }
    let links = ["object.0.detail=2", "transport.scheme=links"].map(String::from);
    add(&Scene::load_with("sphere", &links)?, options)?;
    Ok(list)
}

/// The number of kernels among these pipelines.
pub(super) fn kernels(wanted: &[Wanted]) -> usize {
    wanted.iter().map(|wanted| &wanted.kernel).collect::<BTreeSet<_>>().len()
}

/// The number of all kernels.
pub(super) fn every() -> usize {
    kernel_names().count()
}
