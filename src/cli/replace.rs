//! `--replace KERNEL=FILE`: the user's shaders, checked before anything else runs with them.

use std::collections::BTreeSet;
use std::path::Path;

use clap::Args;

use super::run_args::{quoted, repeated};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Device, kernels_of, replacements};
use milkglass::internals::pipeline::frame::owner;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::{CapacityHints, Session};
use milkglass::measure::conform::Row;
use milkglass::measure::constants::read;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::replace::check;
use milkglass::measure::results::{DeviceFacts, Outcome};
use milkglass::measure::verdict::verdict;
use milkglass::scene::Scene;

/// Shaders that replace built-in ones.
#[derive(Args, Default)]
pub(super) struct ReplaceArgument {
    /// Replace a kernel with your own shader: `transport/blocks/gather/direct=my.comp`; or a file in all kernels that
    /// include it: `transport/links/refine/decide.glsl=my.glsl`. `milkglass shader` prints the built-in ones.
    #[arg(long, value_name = "KERNEL=FILE")]
    replace: Vec<String>,
    /// Values for constants of your own in those shaders: TOML, `["transport/blocks/push"]`, then `NAME = value`.
    #[arg(long, value_name = "FILE", requires = "replace")]
    constants: Option<String>,
}

impl ReplaceArgument {
    /// The arguments as the end of a shell command that repeats this one.
    pub(super) fn again(&self) -> String {
        let words = |(option, value): (&str, &String)| format!(" {option} {}", quoted(value));
        self.given().map(words).collect()
    }

    /// The pairs of kernel and file, as given.
    pub(super) fn pairs(&self) -> &[String] {
        &self.replace
    }

    /// The pairs and the file of constants, for people to read.
    pub(super) fn told(&self) -> Vec<String> {
        let constants = self.constants.iter().map(|file| format!("constants of {file}"));
        self.replace.iter().cloned().chain(constants).collect()
    }

    /// The arguments as words of a command line.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.given().flat_map(|(option, value)| [option, value])
    }

    /// The options that are given, with their values.
    fn given(&self) -> impl Iterator<Item = (&str, &String)> {
        let pairs = self.replace.iter().map(|pair| ("--replace", pair));
        pairs.chain(self.constants.iter().map(|file| ("--constants", file)))
    }

    /// The kernels' names and SPIR-V.
    pub(super) fn load(&self) -> Result<Vec<(String, Vec<u32>)>> {
        let mut loaded: Vec<(String, Vec<u32>)> = Vec::new();
        let mut constants = self.constants.as_ref().map(|file| read(Path::new(file))).transpose()?.unwrap_or_default();
        for pair in &self.replace {
            let Some((kernel, file)) = pair.split_once('=').filter(|(_, file)| !file.is_empty()) else {
                let fault = Input::new("not a kernel and a file").key("--replace").found(pair);
                return Err(fault.expected("transport/blocks/gather/direct=my.comp, for example").into());
            };
            if let Some(twice) = kernels_of(kernel).into_iter().find(|own| loaded.iter().any(|(known, _)| known == own))
            {
                return Err(Input::new("this kernel is replaced twice").key("--replace").found(twice).into());
            }
            let own = constants.iter().position(|(known, ..)| known == kernel).map(|at| constants.swap_remove(at).2);
            loaded.extend(replacements(kernel, Path::new(file), &own.unwrap_or_default())?);
        }
        if let Some((kernel, line, given)) = constants.into_iter().next() {
            let names: Vec<&str> = self.names().collect();
            let fault = Input::new("no shader replaces this kernel").file(&given.file).key(kernel);
            return Err(Input { line, ..fault.expected(names.join(", ")) }.into());
        }
        Ok(loaded)
    }

    /// The names to replace, as given.
    fn names(&self) -> impl Iterator<Item = &str> {
        self.replace.iter().filter_map(|pair| Some(pair.split_once('=')?.0))
    }

    /// For each name to replace, the stages of its kernels.
    pub(super) fn stages(&self) -> Vec<Vec<String>> {
        let of = |name| kernels_of(name).into_iter().filter_map(|kernel| Some(owner(kernel)?.name.to_string()));
        self.names().map(|name| of(name).collect()).collect()
    }

    /// An error for a name of which no kernel is among those that `whose` runs, if there is one.
    pub(super) fn unused(&self, run: &BTreeSet<String>, whose: &str) -> Option<Input> {
        let unused = self.names().find(|name| !kernels_of(name).iter().any(|kernel| run.contains(*kernel)))?;
        let fault = Input::new(format!("{whose} does not run this kernel")).key("--replace").found(unused);
        Some(fault.expected(run.iter().map(String::as_str).collect::<Vec<_>>().join(", ")))
    }

    /// The device with these shaders, and whether their values are those of the reference: checked on the first of
    /// these setups that together run all replaced kernels, or as many as any of them runs. None if no shader is given.
    /// If `unchecked`, values that are wrong are told and no error.
    pub(super) fn on(
        &self,
        device: Option<&Device>,
        setups: &[(&Scene, Options)],
        unchecked: bool,
    ) -> Result<Option<(Device, bool)>> {
        let loaded = self.load()?;
        if loaded.is_empty() {
            return Ok(None);
        }
        let Some(device) = device else {
            let fault = Input::new("shaders run on a Vulkan device only").key("--replace").found("the CPU");
            return Err(fault.expected("a device that `milkglass devices` lists").into());
        };
        let device = replaced(device, &loaded)?;
        let names: Vec<String> = loaded.into_iter().map(|(name, _)| name).collect();
        let rows = check(&device, &self.fixtures(&names, setups)?)?;
        let (good, bad): (Vec<_>, Vec<_>) = rows.iter().partition(|row| row.faults.is_empty());
        for row in good {
            tell!("{}: {} words conform to the reference", row.stage, row.distances.words);
        }
        if unchecked {
            for row in &bad {
                let first = row.faults.first().map_or("", String::as_str);
                tell!("{}: other values than the reference, so what follows is unproved: {first}", row.stage);
            }
            return Ok(Some((device, bad.is_empty())));
        }
        let outcome = |row: &Row| Outcome::new(device.adapter(), row, repeated(device.name()));
        for row in &bad {
            let (facts, layer) = (DeviceFacts::new(device.adapter()), device.layer());
            tell!("\n{}", verdict(&outcome(row), &facts, layer.as_deref(), &names));
        }
        match bad.as_slice() {
            [] => Ok(Some((device, true))),
            [row, ..] => {
                Err(Error::Check(format!("the replaced stage {} gives other values than the reference", row.stage)))
            }
        }
    }

    /// The setups that run one of these kernels which those before them do not run. Tells which kernels none of them
    /// runs; an error if these are all that a name stands for.
    fn fixtures(&self, kernels: &[String], setups: &[(&Scene, Options)]) -> Result<Vec<Fixture>> {
        let (mut fixtures, mut run) = (Vec::new(), BTreeSet::new());
        let mut idle: Vec<&String> = kernels.iter().collect();
        for (scene, options) in setups {
            if idle.is_empty() {
                break;
            }
            let session = Session::new(scene, None, *options)?;
            let dispatches = session.dispatches(Change::EVERYTHING.and(Change::TONE))?;
            let own: BTreeSet<String> = dispatches.into_iter().map(|dispatch| dispatch.kernel).collect();
            if idle.iter().any(|kernel| own.contains(*kernel)) {
                fixtures.push(Fixture::new(&scene.name, scene, *options, CapacityHints::default())?);
            }
            idle.retain(|kernel| !own.contains(*kernel));
            run.extend(own);
        }
        if let Some(fault) = self.unused(&run, setups.first().map_or("the scene", |(scene, _)| &scene.name)) {
            return Err(fault.into());
        }
        if !idle.is_empty() {
            let names: Vec<&str> = idle.iter().map(|kernel| kernel.as_str()).collect();
            tell!("replaced, but not compared, as nothing here runs it: {}", names.join(", "));
        }
        Ok(fixtures)
    }
}

/// The device with these kernels replaced, and with the features that they need.
pub(super) fn replaced(device: &Device, kernels: &[(String, Vec<u32>)]) -> Result<Device> {
    kernels.iter().try_fold(device.clone(), |device, (name, words)| device.replacing(name, words.clone()))
}
