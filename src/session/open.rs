//! Opens a session for a scene: alone, or after another one, with what that has in common.

use super::capacity::{CapacityHints, Lists};
use super::choice::Choice;
use super::device_limits::holds;
use super::incremental::share_budget;
use super::memory_estimate;
use super::octree::OctreeTransport;
use super::run::{Fixed, Session};
use super::subdivide::subdivide;
use super::walk::{WalkControl, WalkTransport, prepare_walk};
use crate::error::Result;
use crate::gpu::Device;
use crate::phases::phase;
use crate::pipeline::plan::{Change, Mode, Options, Plan, ShadingMethod};
use crate::prepare::layers::drop_unlooked;
use crate::prepare::reach::reach;
use crate::prepare::receivers::{by_pixel, lit_at};
use crate::prepare::scene::prepare;
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
        room: CapacityHints,
    ) -> Result<Self> {
        memory_estimate::check(scene, options)?;
        beside(&scene.objects, options.transport)?;
        let octree = match options.transport {
            ShadingMethod::Octree => Some(OctreeTransport::new(&scene.transport)?),
            _ => None,
        };
        let local = local(&scene.transport, options.transport);
        device.map_or(Ok(()), |_| holds(scene))?;
        let units = Units::of(&scene.objects);
        reach(&scene.objects, units)?;
        let linked = matches!(options.transport, ShadingMethod::Hierarchy | ShadingMethod::Auto);
        let blocks = scene.transport.scheme == Scheme::Blocks && linked;
        // Subdivide where light and radiosity need it; code below sees only that scene.
        let estimate = options.estimate && (blocks || options.transport == ShadingMethod::Diffusion);
        let finer = if local.is_none() { subdivide(scene, options, estimate)? } else { None };
        let (asked, (scene, parts)) = match finer {
            Some(finer) => (Some(scene.clone()), finer),
            None => (None, (scene.clone(), Vec::new())),
        };
        if asked.is_some() {
            memory_estimate::check(&scene, options)?;
        }
        let choice =
            Choice::of(&scene, options.transport, before.as_deref().map(|before| (&before.choice, &before.scene)))?;
        let solves = choice.solves(&scene);
        let (by_pixel, why) = by_pixel(&scene, options);
        let known = before.as_deref().map(|before| (&before.scene, &before.prepared));
        let shown = (by_pixel, lit_at(&scene, options));
        let mut prepared = phase("preparing the scene", || prepare(&scene, shown, (local, &solves), known));
        blur(&mut prepared, &scene, unwrap(&scene, local)?);
        if options.transport == ShadingMethod::Walk {
            prepare_walk(&mut prepared, &scene, WalkControl::default())?;
        }
        drop_unseen(&mut prepared.state, options);
        drop_unlooked(&mut prepared.state, options);
        prepared.state.keep = options.mode != Mode::OnTheFly || solves.contains(&true);
        prepared.state.method.estimate = options.estimate && (blocks || solves.contains(&true));
        prepared.state.method.any_light = matches!(options.mode, Mode::Render | Mode::Incremental) && blocks;
        prepared.state.method.incremental =
            options.mode == Mode::Incremental && options.transport == ShadingMethod::Hierarchy && !blocks;
        share_budget(&mut prepared.state, scene.transport.budget)?;
        let receivers = (if by_pixel { "receivers at triangles" } else { "receivers at pixels" }, why);
        let plan = choice.told(Plan::new(&prepared.state, options).without(receivers.clone()));
        // Links and form factors are separate lists, and everything else needs memory as well.
        let room = CapacityHints { kept: room.kept.min(scene.memory.left() / 4), ..room };
        let lists = match before.as_deref() {
            Some(before) => before.lists.again(&mut prepared, &before.prepared.state),
            None => Lists::new(room, device.map(Device::limits)).cut_new(&mut prepared),
        };
        let gpu = match before.as_deref_mut() {
            Some(before) => before.gpu.take(),
            None => device.map(|device| DeviceState::new(device, false)).transpose()?,
        };
        let (retries, relinks) = before.as_deref().map_or((0, 0), |before| (before.retries, before.relinks));
        let held = before.as_deref().and_then(|before| before.held);
        let fixed = Fixed { asked, options, room, receivers };
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
            sampled: false,
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
            fixed,
        };
        let fits = match options.transport {
            ShadingMethod::Hierarchy | ShadingMethod::Auto | ShadingMethod::Diffusion => {
                session.lists.too_much(&session.prepared.state)
            }
            _ => Ok(()),
        };
        let sized = fits.and_then(|()| session.resize());
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
}
