//! Opens a session for a scene: alone, or after another one, with what that has in common.

use super::capacity::{CapacityHints, Lists};
use super::choice::Choice;
use super::device_limits::holds;
use super::incremental::share_budget;
use super::memory_estimate;
use super::octree::OctreeTransport;
use super::run::{Fixed, Session};
use super::subdivide::{Parts, subdivide};
use super::walk::{WalkControl, WalkTransport, prepare_walk};
use crate::error::Result;
use crate::gpu::Device;
use crate::phases::phase;
use crate::pipeline::plan::{Change, Mode, Options, Plan, ShadingMethod};
use crate::prepare::layers::drop_unlooked;
use crate::prepare::reach::reach;
use crate::prepare::receivers::{by_pixel, lit_at};
use crate::prepare::scene::{Prepared, prepare};
use crate::prepare::shading::local;
use crate::prepare::single_scattering::beside;
use crate::prepare::texture_charts::{blur, unwrap};
use crate::prepare::textures::drop_unseen;
use crate::prepare::units::Units;
use crate::scene::Scene;
use crate::state::{DeviceState, Scheme};

impl Session {
    /// The same as [`Session::new`], with initial capacities of the lists.
    pub fn with_capacity(
        scene: &Scene,
        device: Option<&Device>,
        options: Options,
        hints: CapacityHints,
    ) -> Result<Self> {
        Self::after(None, scene, device, options, hints)
    }

    /// The same with what an earlier session has: its device's buffers and pipelines, which it loses if this succeeds;
    /// the trees of meshes that are the same; and the capacities of its lists, if there are as many receivers.
    pub(crate) fn after(
        mut before: Option<&mut Self>,
        scene: &Scene,
        device: Option<&Device>,
        options: Options,
        hints: CapacityHints,
    ) -> Result<Self> {
        memory_estimate::check(scene, options)?;
        beside(&scene.objects, options.transport)?;
        let octree = (options.transport == ShadingMethod::Octree).then(|| OctreeTransport::new(&scene.transport));
        let octree = octree.transpose()?;
        device.map_or(Ok(()), |_| holds(scene))?;
        reach(&scene.objects, Units::of(&scene.objects))?;
        // Code below sees only the subdivided scene.
        let (asked, scene, parts) = cut(scene, options)?;
        let choice =
            Choice::of(&scene, options.transport, before.as_deref().map(|before| (&before.choice, &before.scene)))?;
        let solves = choice.solves(&scene);
        let (by_pixel, why) = by_pixel(&scene, options);
        let known = before.as_deref().map(|before| (&before.scene, &before.prepared));
        let mut prepared = prepared(&scene, options, (by_pixel, &solves), known)?;
        let receivers = (if by_pixel { "receivers at triangles" } else { "receivers at pixels" }, why);
        let plan = choice.told(Plan::new(&prepared.state, options).without(receivers.clone()));
        // Links and form factors are separate lists, and everything else needs memory as well.
        let hints = CapacityHints { kept: hints.kept.min(scene.memory.left() / 4), ..hints };
        let lists = match before.as_deref() {
            Some(before) => before.lists.again(&mut prepared, &before.prepared.state),
            None => Lists::new(hints, device.map(Device::limits)).cut_new(&mut prepared),
        };
        let gpu = match before.as_deref_mut() {
            Some(before) => before.gpu.take(),
            None => device.map(|device| DeviceState::new(device, false)).transpose()?,
        };
        let (retries, relinks, held) = before.as_deref().map_or((0, 0, None), Self::kept);
        let mut session = Self {
            prepared,
            plan,
            gpu,
            retries,
            relinks,
            moved: false,
            linked: false,
            spent: 0,
            sharp: None,
            parts,
            not_kept: None,
            samples_done: 0,
            coverage: Vec::new(),
            held,
            shifted: false,
            failed: false,
            scene,
            lists,
            pending: Change::EVERYTHING.into(),
            octree,
            walk: WalkTransport::default(),
            solves: Vec::new(),
            choice,
            fixed: Fixed { asked, options, hints, receivers },
        };
        let sized = session.fits().and_then(|()| session.resize());
        match (session.unless_too_much(sized), before) {
            (Ok(_), _) => Ok(session),
            (Err(error), None) => Err(error),
            (Err(error), Some(before)) => {
                // The earlier session goes on; its next frame restores its buffers.
                (before.gpu, before.failed) = (session.gpu, true);
                Err(error)
            }
        }
    }

    /// What a session built from this one keeps: how often frames were repeated, and the exposure that was held.
    fn kept(&self) -> (usize, usize, Option<f64>) {
        (self.retries, self.relinks, self.held)
    }

    /// Whether its lists fit at all.
    fn fits(&self) -> Result<()> {
        match self.fixed.options.transport {
            ShadingMethod::Hierarchy | ShadingMethod::Auto | ShadingMethod::Diffusion => {
                self.lists.too_much(&self.prepared.state)
            }
            _ => Ok(()),
        }
    }
}

/// Whether light is carried between blocks.
fn blocks(scene: &Scene, options: Options) -> bool {
    let linked = matches!(options.transport, ShadingMethod::Hierarchy | ShadingMethod::Auto);
    scene.transport.scheme == Scheme::Blocks && linked
}

/// The scene as it was asked for, if it has to be subdivided; the scene to use, and the parts of its triangles.
fn cut(scene: &Scene, options: Options) -> Result<(Option<Scene>, Scene, Vec<Parts>)> {
    let estimate = options.estimate && (blocks(scene, options) || options.transport == ShadingMethod::Diffusion);
    let finer = match local(&scene.transport, options.transport) {
        None => subdivide(scene, options, estimate)?,
        Some(_) => None,
    };
    let Some((finer, parts)) = finer else { return Ok((None, scene.clone(), Vec::new())) };
    memory_estimate::check(&finer, options)?;
    Ok((Some(scene.clone()), finer, parts))
}

/// The state of a scene for a method, with what an earlier one has in common with it.
fn prepared(
    scene: &Scene,
    options: Options,
    (by_pixel, solves): (bool, &[bool]),
    known: Option<(&Scene, &Prepared)>,
) -> Result<Prepared> {
    let local = local(&scene.transport, options.transport);
    let shown = (by_pixel, lit_at(scene, options));
    let mut prepared = phase("preparing the scene", || prepare(scene, shown, (local, solves), known));
    blur(&mut prepared, scene, unwrap(scene, local)?);
    if options.transport == ShadingMethod::Walk {
        prepare_walk(&mut prepared, scene, WalkControl::default())?;
    }
    let state = &mut prepared.state;
    drop_unseen(state, options);
    drop_unlooked(state, options);
    let (blocks, solves) = (blocks(scene, options), solves.contains(&true));
    state.keep = options.mode != Mode::OnTheFly || solves;
    state.method.estimate = options.estimate && (blocks || solves);
    state.method.any_light = matches!(options.mode, Mode::Render | Mode::Incremental) && blocks;
    state.method.incremental =
        options.mode == Mode::Incremental && options.transport == ShadingMethod::Hierarchy && !blocks;
    share_budget(state, scene.transport.budget)?;
    Ok(prepared)
}
