//! Changes of a session's scene between frames: lights, deformations, camera, or another scene.

use super::memory_estimate;
use super::run::Session;
use crate::error::Result;
use crate::hierarchy::Tree;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Plan};
use crate::prepare::camera::camera;
use crate::prepare::lights::lights;
use crate::prepare::receivers::by_pixel;
use crate::prepare::shape::{reach, shape, spoilt};
use crate::scene::{Camera, Light, Object, Scene};
use crate::state::State;

impl Session {
    /// Replaces the lights.
    pub fn set_lights(&mut self, list: &[Light]) -> Result<()> {
        let shape = |state: &State| {
            let groups: Vec<_> = state.objects.iter().map(|object| object.groups.clone()).collect();
            (groups, state.data.object_params[0].shadow_words, state.data.object_params[0].sky)
        };
        if self.fixed.asked.is_some() {
            // Shadow borders move, so the subdivision changes.
            return self.renew(|scene| scene.lights = list.to_vec());
        }
        let before = shape(&self.prepared.state);
        self.scene.lights = list.to_vec();
        lights(&mut self.prepared.state, list, &mut self.prepared.units, &self.scene.objects);
        self.pending = self.pending.and(Change::LIGHT);

        // Other stages or buffer sizes: the first light, the last one removed, or channels that no longer share a
        // group.
        let plan = Plan::new(&self.prepared.state, self.plan.options()).without(self.fixed.receivers.clone());
        if plan.stages.len() != self.plan.stages.len() || before != shape(&self.prepared.state) {
            self.plan = plan;
            self.pending = Change::EVERYTHING;
            return self.resize();
        }
        let inputs = [
            BufferId::object_params,
            BufferId::lights,
            BufferId::camera,
            BufferId::sky,
            BufferId::sky_rows,
            BufferId::sky_columns,
            BufferId::reflection_directions,
            BufferId::layer_lights,
        ];
        self.send(&inputs)
    }

    /// Switches to another scene and reuses what it has in common with the current one. The next frame equals that of a
    /// new session.
    pub fn show(&mut self, new: &Scene) -> Result<()> {
        memory_estimate::check(new, self.plan.options())?;
        let old = self.fixed.asked.as_ref().unwrap_or(&self.scene);
        let same = |(a, b): (&Object, &Object)| a.mesh == b.mesh && a.material == b.material;
        let objects = old.objects.len() == new.objects.len() && old.objects.iter().zip(&new.objects).all(same);
        let deforms = |scene: &Scene| scene.objects.iter().map(|object| object.deforms.clone()).collect::<Vec<_>>();
        let (shape, lights) = (deforms(old) != deforms(new), old.lights != new.lights);
        if !objects || old.transport != new.transport || (shape && !self.keeps_trees(new)) {
            return self.renew(|scene| *scene = new.clone());
        }
        if shape {
            self.set_deforms(new)?;
        }
        if lights {
            self.set_lights(&new.lights)?;
        }
        // Even an equal camera: anti-aliasing has shifted the session's rays.
        self.set_camera(&new.camera)
    }

    /// Which objects' trees are rebuilt for their deformed shape, and why.
    #[must_use]
    pub fn rebuilt(&self) -> Vec<String> {
        let grown = self.prepared.spoilt.iter().enumerate().filter_map(|(object, growth)| Some((object, (*growth)?)));
        let says = |(object, growth)| {
            format!("object {object}: deformed, its clusters would be {growth:.2} times as wide; tree rebuilt")
        };
        grown.map(says).collect()
    }

    /// Whether each layered object's depth maps are repacked by islands or used unchanged, and why.
    #[must_use]
    pub fn maps(&self) -> &[String] {
        &self.prepared.maps
    }

    /// Whether a new session for these deformations would have the same trees.
    fn keeps_trees(&self, new: &Scene) -> bool {
        let (prepared, units) = (&self.prepared, self.prepared.units);
        let serves = |(object, tree): (&Object, &Tree)| spoilt(object, new.transport.hierarchy, units, tree).is_none();
        self.fixed.asked.is_none()
            && prepared.spoilt.iter().all(Option::is_none)
            && new.objects.iter().zip(&prepared.trees).all(serves)
    }

    /// Adopts the deformations of a scene with the same objects.
    fn set_deforms(&mut self, new: &Scene) -> Result<()> {
        for (own, new) in self.scene.objects.iter_mut().zip(&new.objects) {
            own.deforms.clone_from(&new.deforms);
        }
        let sizes = |state: &State| (state.data.deforms.len(), state.data.morphs.len());
        let before = sizes(&self.prepared.state);
        reach(&self.scene.objects, self.prepared.units)?;
        let places = self.state().method.incremental.then(|| self.state().data.positions.clone());
        shape(&mut self.prepared.state, &self.scene.objects, self.prepared.units);
        self.pending = Change::EVERYTHING;
        if let Some(before) = places {
            self.unlink_where_much_moves(&before);
        }
        if sizes(&self.prepared.state) != before {
            // Another set of stages, or larger buffers.
            self.plan = Plan::new(&self.prepared.state, self.plan.options()).without(self.fixed.receivers.clone());
            return self.resize();
        }
        // Positions as well: no stage writes those of an object whose last deformation is gone.
        self.send(&[BufferId::object_params, BufferId::deforms, BufferId::morphs, BufferId::positions])
    }

    /// Replaces the camera. The picture may change its size.
    pub fn set_camera(&mut self, new: &Camera) -> Result<()> {
        let (before, size) = (self.scene.camera.environment, self.scene.camera.size);
        self.scene.camera = new.clone();
        if let Some(asked) = &mut self.fixed.asked {
            asked.camera = new.clone();
        }
        let pixels = self.state().objects.iter().any(|object| object.by_pixel);
        if (pixels && size != new.size) || pixels != by_pixel(&self.scene, self.plan.options()).0 {
            // The receivers change.
            return self.renew(|scene| scene.camera = new.clone());
        }
        self.pending = self.pending.and(Change::VIEW);
        camera(&mut self.prepared.state, new, self.prepared.units);
        if before != new.environment {
            self.plan = Plan::new(&self.prepared.state, self.plan.options()).without(self.fixed.receivers.clone());
        }
        self.size_picture();
        self.check_bindings()?;
        self.send(&[BufferId::camera])
    }

    /// Rebuilds the session for the scene after this change.
    fn renew(&mut self, change: impl FnOnce(&mut Scene)) -> Result<()> {
        let device = self.device().cloned();
        let mut scene = self.fixed.asked.clone().unwrap_or_else(|| self.scene.clone());
        change(&mut scene);
        *self = Self::with_capacity(&scene, device.as_ref(), self.plan.options(), self.fixed.room)?;
        Ok(())
    }

    /// Shifts the rays from the pixels' centres, in pixels, until the camera is set again.
    pub(crate) fn shift(&mut self, place: [f64; 2]) -> Result<()> {
        if let Some(camera) = self.prepared.state.data.camera.first_mut() {
            [camera.shift_x, camera.shift_y] = place.map(|x| 2.0 * x as f32);
        }
        self.pending = self.pending.and(Change::VIEW);
        self.send(&[BufferId::camera])
    }
}
