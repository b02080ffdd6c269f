//! Which pipelines to compile: those of the plan of a scene, or those of everything.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::arguments::Arguments;
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::kernel_names;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::requirements::KernelRequirements;
use milkglass::internals::session::run::Session;
use milkglass::internals::state::{Width, dispatches};
use milkglass::measure::fixtures::{EVERY_KERNEL, made};
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

impl Wanted {
    /// The pipeline of a kernel with these constants.
    fn of(kernel: &str, values: &[u32]) -> Result<Self> {
        let required = KernelRequirements { name: kernel.to_string(), constants: values.to_vec(), dispatches: 1 };
        Ok(Self { constants: required.specialized()?, kernel: required.name, values: required.constants })
    }
}

/// The pipelines of a scene's plan.
pub(super) fn of_scene(scene: &Scene, options: Options) -> Result<Vec<Wanted>> {
    let (session, mut list) = (Session::new(scene, None, options)?, Vec::new());
    for stage in session.needs(Change { relink: true, tone: true, ..Change::EVERYTHING })? {
        for pipeline in &stage.kernels {
            list.push(Wanted::of(&pipeline.name, &pipeline.constants)?);
        }
    }
    Ok(list)
}

/// The pipelines of the scene that is asked for; with `--all` of all built-in scenes, and of fixtures that run every
/// other kernel, each once.
pub(super) fn wanted(arguments: &Arguments) -> Result<Vec<Wanted>> {
    let (scene, options) = (arguments.run.of(&arguments.scene), arguments.run.options());
    if !arguments.all {
        if scene.scene.is_empty() {
            let fault = Input::new("no scene is given").key("SCENE");
            return Err(fault.expected("a scene, or --all").into());
        }
        return of_scene(&scene.load()?, options);
    }
    let mut list = Vec::new();
    for (name, ..) in BUILTIN {
        list.extend(of_scene(&Scene::load_with(name, &scene.sets)?, options)?);
    }
    for fixture in made(|name| EVERY_KERNEL.contains(&name))? {
        for dispatch in dispatches(&fixture.state, &fixture.steps, Width::GPU)? {
            list.push(Wanted::of(&dispatch.kernel, &dispatch.constants)?);
        }
    }
    let mut known = BTreeSet::new();
    list.retain(|wanted| known.insert(wanted.clone()));
    Ok(list)
}

/// The number of kernels among these pipelines.
pub(super) fn kernels(wanted: &[Wanted]) -> usize {
    wanted.iter().map(|wanted| &wanted.kernel).collect::<BTreeSet<_>>().len()
}

/// The number of all kernels but those of measurements.
pub(super) fn every() -> usize {
    kernel_names().filter(|name| !name.starts_with("measure/")).count()
}
