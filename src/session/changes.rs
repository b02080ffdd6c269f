//! Changes of a session's scene between frames: lights, deformations, camera, or another scene.

use super::memory_estimate;
use super::run::Session;
use crate::error::Result;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Changes};
use crate::prepare::camera::{camera, shift, tones};
use crate::prepare::compactness::Compactness;
use crate::prepare::lights::lights;
use crate::prepare::material::{self, differs_by_coefficients, quadrature};
use crate::prepare::pixel_lights::pixel_lights;
use crate::prepare::place::place;
use crate::prepare::reach::reach;
use crate::prepare::receivers::by_pixel;
use crate::prepare::shape::{deform_all, shape};
use crate::prepare::single_scattering::media;
use crate::prepare::units::Units;
use crate::scene::{Camera, Light, Object, Scene};
use crate::state::{Granularity, Group, Scheme, Stage, State};

/// The inputs that lights and materials write.
const LIGHTING: &[BufferId] = &[
    BufferId::object_params,
    BufferId::lights,
    BufferId::pixel_lights,
    BufferId::camera,
    BufferId::sky,
    BufferId::sky_rows,
    BufferId::sky_columns,
    BufferId::sky_cells,
    BufferId::layer_lights,
    BufferId::scattering_media,
];

/// The values that decide how large buffers are, apart from the mesh and the picture.
#[derive(PartialEq)]
struct Layout {
    groups: Vec<Vec<Group>>,
    shadow_words: [u32; 2],
    sky: [u32; 2],
    cells: usize,
}

impl Layout {
    fn of(state: &State) -> Self {
        let params = &state.data.object_params[0];
        Self {
            groups: state.objects.iter().map(|object| object.groups.clone()).collect(),
            shadow_words: [params.shadow_words, state.data.camera.first().map_or(0, |camera| camera.shadow_words)],
            sky: params.sky,
            cells: state.data.sky_cells.len(),
        }
    }
}

impl Session {
    /// Replaces the lights.
    pub fn set_lights(&mut self, list: &[Light]) -> Result<()> {
        if self.cut_for_light() {
            // Shadow borders move, so the subdivision changes.
            return self.renew(|scene| scene.lights = list.to_vec());
        }
        let before = Layout::of(&self.prepared.state);
        self.scenes().for_each(|scene| scene.lights = list.to_vec());
        lights(&mut self.prepared.state, list, &mut self.prepared.units, &self.scene.objects);
        self.adopt(&before, Change::LIGHT.into(), LIGHTING)
    }

    /// Replaces the materials by those of a scene with the same objects.
    fn set_materials(&mut self, new: &Scene) -> Result<()> {
        let coefficients = |(old, new): (&Object, &Object)| {
            differs_by_coefficients(&old.material, &new.material, self.state().method.local)
        };
        let alike = self.scene.objects.iter().zip(&new.objects).all(coefficients);
        if self.cuts_anew(new) || !alike || !self.choice.stays(new) {
            return self.renew(|scene| {
                scene.objects.iter_mut().zip(&new.objects).for_each(|(old, new)| old.material = new.material.clone());
            });
        }
        let (state, units) = (&mut self.prepared.state, &mut self.prepared.units);
        let (before, mut changes) = (Layout::of(state), Changes::default());
        for (number, (old, new)) in self.scene.objects.iter_mut().zip(&new.objects).enumerate() {
            if old.material != new.material {
                // The dipole does not depend on g.
                let scatters = if old.material.g == new.material.g { Change::default() } else { Change::MATERIAL };
                old.material = new.material.clone();
                changes.add_to(number, material::change(state, number, &old.material, *units).and(scatters));
            }
        }
        let asked = self.fixed.asked.iter_mut().flat_map(|asked| asked.objects.iter_mut().zip(&new.objects));
        asked.for_each(|(old, new)| old.material.clone_from(&new.material));
        self.choice.adopt(&self.scene);
        if !state.data.scattering_media.is_empty() {
            media(state, &self.scene.objects, *units);
        }
        if quadrature(state, &self.scene) {
            changes.add(Change::MATERIAL);
        }
        // Groups of channels and directions of reflection.
        lights(state, &self.scene.lights, units, &self.scene.objects);
        self.adopt(&before, changes, LIGHTING)
    }

    /// Adopts changes that were made to the state's inputs: other stages, other sizes, or other values of `inputs`.
    fn adopt(&mut self, before: &Layout, changes: Changes, inputs: &[BufferId]) -> Result<()> {
        self.pending = std::mem::take(&mut self.pending).and(&changes);
        let state = &self.prepared.state;
        let plan = self.plan_of(self.plan.options());
        let enters: Vec<&Stage> = plan.stages.iter().copied().filter(|stage| !self.plan.has(stage)).collect();
        // Stages of the whole scene run for a change of any object, the others only for one of each.
        let runs = |stage: &&Stage| match stage.granularity {
            Granularity::Scene => (stage.runs)(&plan.update(state, changes.any(), None)),
            _ => (0..state.objects.len())
                .all(|object| (stage.runs)(&plan.update(state, changes.of(object), Some(object)))),
        };
        let (now, run) = (Layout::of(state), enters.iter().all(runs));
        let same = enters.is_empty() && plan.stages.len() == self.plan.stages.len();
        self.plan = plan;
        if same && *before == now {
            return self.send(inputs);
        }
        // Blocks have lists for each group of channels. A stage that was not there has to run now.
        let blocks = self.prepared.state.method.scheme == Scheme::Blocks;
        if (blocks && before.groups != now.groups) || !run {
            self.pending = Change::EVERYTHING.into();
            return self.resize();
        }
        self.adjust(inputs)
    }

    /// Switches to another scene and reuses what it has in common with the current one. The next frame equals that of a
    /// new session.
    pub fn show(&mut self, new: &Scene) -> Result<()> {
        memory_estimate::check(new, self.plan.options())?;
        let old = self.fixed.asked.as_ref().unwrap_or(&self.scene);
        let pairs = || old.objects.iter().zip(&new.objects);
        let meshes = old.objects.len() == new.objects.len() && pairs().all(|(old, new)| old.mesh == new.mesh);
        let materials = pairs().any(|(old, new)| old.material != new.material);
        let shape = pairs().any(|(old, new)| old.deforms != new.deforms);
        let (lights, old_camera) = (old.lights != new.lights, old.camera.clone());
        let placed = pairs().any(|(old, new)| (old.rotation, old.position) != (new.rotation, new.position));
        let units = Units { light: self.prepared.units.light, ..Units::of(&new.objects) };
        // Triangles are cut for their lights, and lengths are internal.
        let fits = !placed || (!self.cut_for_light() && units.length == self.prepared.units.length);
        if !meshes || !fits || old.transport != new.transport || (shape && !self.keeps_trees(new)) {
            return self.renew(|scene| *scene = new.clone());
        }
        if shape || placed {
            reach(&new.objects, units)?;
        }
        if placed {
            self.set_places(new, units)?;
        }
        if materials {
            self.set_materials(new)?;
        }
        if shape {
            self.set_deforms(new)?;
        }
        if lights {
            self.set_lights(&new.lights)?;
        }
        if old_camera != new.camera {
            self.set_camera(&new.camera)?;
        }
        Ok(())
    }

    /// Whether a new session for these deformations would have the same trees.
    fn keeps_trees(&mut self, new: &Scene) -> bool {
        let other = |(old, new): (&Object, &Object)| old.deforms.is_empty() != new.deforms.is_empty();
        let other = self.scene.objects.iter().zip(&new.objects).any(other);
        if self.cut_for_light() || other || self.prepared.spoilt.iter().any(Option::is_some) {
            return false;
        }
        let (prepared, hierarchy) = (&mut self.prepared, new.transport.hierarchy);
        let units = prepared.units;
        let trees = prepared.trees.iter().zip(&mut prepared.compactness);
        new.objects.iter().zip(trees).filter(|(object, _)| !object.deforms.is_empty()).all(|(object, (tree, known))| {
            let known = known.get_or_insert_with(|| Compactness::new(object, tree, units));
            known.spoilt(object, hierarchy, units).is_none()
        })
    }

    /// Places the objects as they are in a scene with the same objects and lengths.
    fn set_places(&mut self, new: &Scene, units: Units) -> Result<()> {
        let objects = self.scenes().flat_map(|scene| scene.objects.iter_mut().zip(&new.objects));
        objects.for_each(|(old, new)| (old.rotation, old.position) = (new.rotation, new.position));
        let (state, scene) = (&mut self.prepared.state, &mut self.scene);
        let before = Layout::of(state);
        // Where the middle of the scene is another one, every place in it is rounded in another way.
        let all = units != self.prepared.units || before.shadow_words != [0; 2];
        self.prepared.units = units;
        let mut changes = Changes::from(Change::VIEW);
        for (object, moved) in place(state, &scene.objects, units).into_iter().enumerate() {
            changes.add_to(object, if moved { Change::PLACE.and(Change::LIGHT) } else { Change::default() });
        }
        if all {
            changes.add(Change::LIGHT);
        }
        camera(state, &scene.camera, units);
        (self.shifted, self.samples_done) = (false, 0);
        lights(state, &scene.lights, &mut self.prepared.units, &scene.objects);
        self.adopt(&before, changes, LIGHTING)
    }

    /// Adopts the deformations of a scene with the same objects.
    fn set_deforms(&mut self, new: &Scene) -> Result<()> {
        let objects = self.scenes().flat_map(|scene| scene.objects.iter_mut().zip(&new.objects));
        objects.for_each(|(old, new)| old.deforms.clone_from(&new.deforms));
        let inputs = [
            BufferId::deforms,
            BufferId::morphs,
            BufferId::skin_vertices,
            BufferId::skin_joints,
            BufferId::skin_targets,
            BufferId::skin_weights,
            BufferId::skin_matrices,
        ];
        let sizes = |state: &State| inputs.map(|id| state.data.bytes(id).len());
        let parts = |state: &State| state.objects.iter().map(|object| object.deforms > 0).collect::<Vec<_>>();
        let (before, deformed) = (sizes(self.state()), parts(self.state()));
        let places = self.state().method.incremental.then(|| self.state().data.positions.clone());
        shape(&mut self.prepared.state, &self.scene.objects, self.prepared.units);
        self.pending.add(Change::EVERYTHING);
        self.moved = true;
        if let Some(before) = places {
            self.deform();
            self.unlink_where_much_moves(&before);
        }
        if sizes(self.state()) != before {
            // Another set of stages, or larger buffers.
            self.deform();
            self.plan = self.plan_of(self.plan.options());
            return self.resize();
        }
        if parts(self.state()) != deformed {
            // No stage writes the positions of an object whose last deformation is gone.
            self.deform();
            self.send(&[BufferId::positions])?;
        }
        self.send(&[BufferId::object_params])?;
        self.send(&inputs)
    }

    /// Deforms the vertices on the host, too, if that is still to be done: a frame does not need it.
    pub fn deform(&mut self) {
        if std::mem::take(&mut self.moved) {
            deform_all(&mut self.prepared.state);
        }
    }

    /// Replaces the camera. The picture may change its size. Another exposure or tone curve alone changes nothing that
    /// stages before `tone` depend on.
    pub fn set_camera(&mut self, new: &Camera) -> Result<()> {
        let before = std::mem::replace(&mut self.scene.camera, new.clone());
        self.fixed.asked.iter_mut().for_each(|asked| asked.camera = new.clone());
        if before == (Camera { exposure: before.exposure, tone: before.tone, ..new.clone() }) {
            tones(&mut self.prepared.state, new);
            return self.send(&[BufferId::tones]);
        }
        let pixels = self.state().objects.iter().any(|object| object.by_pixel);
        if (pixels && before.size != new.size) || pixels != by_pixel(&self.scene, self.plan.options()).0 {
            // The receivers change.
            return self.renew(|scene| scene.camera = new.clone());
        }
        self.pending.add(Change::VIEW);
        (self.shifted, self.samples_done) = (false, 0);
        camera(&mut self.prepared.state, new, self.prepared.units);
        pixel_lights(&mut self.prepared.state, &self.scene.lights, self.prepared.units);
        if before.environment != new.environment || (before.samples == 1) != (new.samples == 1) {
            self.plan = self.plan_of(self.plan.options());
        }
        self.size_picture();
        self.check_bindings()?;
        self.send(&[BufferId::camera, BufferId::tones, BufferId::pixel_lights])
    }

    /// Rebuilds the session for the scene after this change.
    fn renew(&mut self, change: impl FnOnce(&mut Scene)) -> Result<()> {
        let device = self.device().cloned();
        let mut scene = self.fixed.asked.clone().unwrap_or_else(|| self.scene.clone());
        change(&mut scene);
        let (options, hints) = (self.fixed.options, self.fixed.hints);
        *self = Self::after(Some(self), &scene, device.as_ref(), options, hints)?;
        Ok(())
    }

    /// Shifts the rays from the pixels' centres, in pixels, and from the lens's middle, in its radii, for sample `k`.
    pub(crate) fn shift(&mut self, place: [f64; 2], lens: [f64; 2], k: u32) -> Result<()> {
        if let Some(record) = self.prepared.state.data.camera.first_mut() {
            shift(record, &self.scene.camera, self.prepared.units, place, lens);
            (record.weight, record.sample_number) = (1.0 / (k + 1) as f32, k);
        }
        self.shifted = [place, lens] != [[0.0; 2]; 2];
        self.pending.add(Change::VIEW);
        self.send(&[BufferId::camera])
    }
}
