//! From a checked scene to the state that a frame starts from: centred, scaled, in tree order.

use glam::DVec3;

use super::blocks::{blocks, link_error, of_picture};
use super::borders::borders;
use super::camera::camera;
use super::compactness::Compactness;
use super::diffusion::{layer_error, steps};
use super::layers::layers;
use super::lights::lights;
use super::material::{coefficients, quadrature};
use super::place::place;
use super::rounding::rounding;
use super::shading;
use super::shape::{deform_all, moved, shape, whole_normals};
use super::single_scattering::media;
use super::textures::texture;
use super::units::Units;
use super::wide::wide;
use crate::dipole::form_factor::ladder::Ladder;
use crate::hierarchy::face_cluster::{self, Method};
use crate::hierarchy::{Tree, median, split};
use crate::layout::{KAPPA_MEAN, KAPPA_RMS, OPAQUE_BY_FACE, OPAQUE_BY_PIXEL, OPAQUE_NOT, ObjectParams, Topology};
use crate::phases::phase;
use crate::scene::{self, Hierarchy, Kappa, Material, Mesh, Scene, Side, Transport};
use crate::state::{Extent, LitAt, Local, Method as Switches, Object, Schedule, Scheme, State, narrow};
use crate::transport::blocks::BLOCK_RECEIVERS;
use crate::view::pixel_receivers::LAYERS;

/// A state ready to run, and what is needed to interpret its results.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The state; lists have no capacity yet.
    pub state: State,
    /// Its units.
    pub units: Units,
    /// The tree of each object.
    pub trees: Vec<Tree>,
    /// How each tree was built.
    pub methods: Vec<Method>,
    /// For each object whose tree was rebuilt for its deformed shape: how much wider the clusters of the rest shape's
    /// tree would have been.
    pub spoilt: Vec<Option<f64>>,
    /// What tells whether each object's tree is spoilt, once that was asked for.
    pub compactness: Vec<Option<Compactness>>,
    /// For each object, the mesh triangle of each triangle of the state.
    pub faces: Vec<Vec<u32>>,
    /// A message about the depth maps of each object that has any.
    pub maps: Vec<String>,
}

impl Prepared {
    /// The object of a triangle of the state, and the triangle's number in that object's mesh.
    pub fn source(&self, face: usize) -> (usize, u32) {
        let object = self.state.object_of(face);
        (object, self.faces[object][face - self.state.objects[object].first.faces])
    }

    /// The triangle of the state for each triangle of all meshes, in order.
    pub fn all_places(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.faces.len()).flat_map(|object| self.places(object))
    }

    /// The triangle of the state for each triangle of an object's mesh.
    pub fn places(&self, object: usize) -> Vec<usize> {
        let first = self.state.objects[object].first.faces;
        let mut places = vec![0; self.faces[object].len()];
        for (place, &face) in self.faces[object].iter().enumerate() {
            places[face as usize] = first + place;
        }
        places
    }
}

/// Builds the trees and the state of a scene. `by_pixel`: whether receivers are at pixels; `lit_at`: where opaque
/// objects are lit; `known`: a scene that was prepared before, from which trees of the same meshes are taken.
///
/// `solves`: for each object whether its transport is diffusion. With `local`, shading takes the place of transport:
/// there are no blocks of receivers, and a texture is applied once, at the exit (except with `Local::Blur`).
pub fn prepare(
    scene: &Scene,
    (by_pixel, lit_at): (bool, LitAt),
    (local, solves): (Option<Local>, &[bool]),
    known: Option<(&Scene, &Prepared)>,
) -> Prepared {
    let mut units = Units::of(&scene.objects);
    let (mut parts, mut trees, mut methods) = (Vec::new(), Vec::new(), Vec::new());
    let (mut faces, mut spoilt) = (Vec::new(), Vec::new());
    for (number, object) in scene.objects.iter().enumerate() {
        let known = known.and_then(|(before, prepared)| {
            let same = before.objects.get(number).is_some_and(|before| before.mesh == object.mesh)
                && before.transport.hierarchy == scene.transport.hierarchy
                && prepared.spoilt[number].is_none();
            same.then(|| (&prepared.trees[number], prepared.methods[number]))
        });
        let tree_of = || tree_of(object, scene.transport.hierarchy, units, known);
        let (tree, made, growth) = phase("building trees", tree_of);
        let any = solves.contains(&true);
        let (part, of_leaves) = state_of(scene, object, &tree, units, (by_pixel, lit_at, local), (any, solves[number]));
        spoilt.push(growth);
        methods.push(made);
        parts.push(part);
        trees.push(tree);
        faces.push(of_leaves);
    }
    let mut state = State::join(parts);
    quadrature(&mut state, scene);
    place(&mut state, &scene.objects, units);
    (0..scene.objects.len()).for_each(|number| rounding(&mut state, number));
    wide(&mut state, &trees);
    if state.method.projected {
        borders(&mut state, &trees);
    }
    whole_normals(&mut state, &scene.objects);
    shape(&mut state, &scene.objects, units);
    deform_all(&mut state);
    let maps = layers(&mut state, &scene.objects, &faces, units);
    media(&mut state, &scene.objects, units);
    camera(&mut state, &scene.camera, units);
    lights(&mut state, &scene.lights, &mut units, &scene.objects);
    let compactness = vec![None; trees.len()];
    Prepared { state, units, trees, methods, spoilt, compactness, faces, maps }
}

/// The tree of an object, how it was built, and, if deformations would have spoilt the rest shape's tree, by how
/// much. `known` is the rest shape's tree, if it was built before.
fn tree_of(
    object: &scene::Object,
    hierarchy: Hierarchy,
    units: Units,
    known: Option<(&Tree, Method)>,
) -> (Tree, Method, Option<f64>) {
    let build = |positions: &[DVec3]| match hierarchy {
        Hierarchy::FaceClusters => face_cluster::build(positions, &object.mesh.triangles),
        Hierarchy::Median => (median::build(positions, &object.mesh.triangles, BLOCK_RECEIVERS), Method::Merged),
        Hierarchy::Butterfly | Hierarchy::ShrinkWrap => {
            split::build(positions, &object.mesh.triangles, &object.mesh.splits)
        }
    };
    let (tree, method) = known.map_or_else(|| build(&object.mesh.positions), |(tree, method)| (tree.clone(), method));
    if object.deforms.is_empty() {
        return (tree, method, None);
    }
    match (Compactness::new(object, &tree, units).spoilt(object, hierarchy, units), moved(object, units)) {
        (Some(growth), Some(moved)) => {
            let (tree, method) = build(&moved);
            (tree, method, Some(growth))
        }
        _ => (tree, method, None),
    }
}

/// The state of one object, and the mesh triangle of each of its triangles.
fn state_of(
    scene: &Scene,
    object: &scene::Object,
    tree: &Tree,
    units: Units,
    (by_pixel, lit_at, local): (bool, LitAt, Option<Local>),
    (any, solves): (bool, bool),
) -> (State, Vec<u32>) {
    let (mesh, transport) = (&object.mesh, &scene.transport);
    let steps = if any { steps(scene) } else { 0 };
    let scheme = if any { Scheme::Blocks } else { transport.scheme };
    let mut state = State { distance: transport.distance, ..State::default() };
    let faces = topology(&mut state, mesh, tree, units.own(object));
    frame(&mut state, &object.material, transport, units, local);
    let mut material = object.material.clone();
    // Objects with layers are lit at their triangles.
    let lit_at = if material.layers.is_some() { LitAt::Faces } else { lit_at };
    let opaque = material.opaque.is_some();
    let plain = opaque && lit_at != LitAt::Faces;
    if plain {
        state.data.object_params[0].opaque = OPAQUE_BY_PIXEL;
    }
    let at_pixels = local.is_some_and(|local| local != Local::Blur);
    if let (Some(texture), true) = (&mut material.texture, plain || (at_pixels && !opaque)) {
        texture.side = Side::Exit;
    }
    // Only the CDRF uses sigma_0.
    material.sigma_0_texture =
        material.sigma_0_texture.filter(|_| matches!(local, Some(Local::Closed | Local::Table(_))));
    state.method = Switches {
        scheme,
        steps,
        order: transport.order,
        estimate: false,
        near: transport.near,
        projected: transport.projects() && local.is_none() && !any,
        local,
        ..Switches::default()
    };
    texture(&mut state, &material, mesh, &faces);
    if matches!(local, Some(Local::Closed | Local::Table(_))) {
        state.data.vertex_order = shading::vertex_order(&state.data);
    }
    if scheme == Scheme::Blocks && !opaque && local.is_none() {
        state.data.blocks = if by_pixel { of_picture(scene.camera.size) } else { blocks(&state) };
        state.data.object_params[0].by_pixel = u32::from(by_pixel);
        let blocks = state.data.blocks.len() as u32;
        state.data.object_params[0].blocks = blocks;
        state.data.object_params[0].usual_blocks = if by_pixel { blocks / LAYERS } else { blocks };
    }
    let data = &state.data;
    let (vertices, nodes, blocks) = (data.positions.len(), data.topology.len(), data.blocks.len());
    let by_pixel = by_pixel && !opaque;
    let receivers = if by_pixel { BLOCK_RECEIVERS * blocks / LAYERS as usize } else { faces.len() };
    let count = Extent { vertices, faces: faces.len(), nodes, blocks, receivers };
    let vectors = if solves { steps as usize + 1 } else { 0 };
    state.objects = vec![Object { count, opaque, lit_at, by_pixel, vectors, ..Object::default() }];
    if solves {
        state.data.object_params[0].link_error = layer_error(transport.tolerance) as f32;
    }
    (state, faces)
}

/// Fills mesh and tree, triangles in the order of the leaves; returns the mesh triangle of each.
fn topology(state: &mut State, mesh: &Mesh, tree: &Tree, units: Units) -> Vec<u32> {
    let data = &mut state.data;
    data.positions = mesh.positions.iter().map(|&p| narrow(units.inside(p))).collect();
    let mut faces = Vec::with_capacity(mesh.triangles.len());
    for node in 0..tree.nodes() {
        let mut face = u32::MAX;
        if tree.is_leaf(node) {
            face = faces.len() as u32;
            faces.push(tree.face[node]);
            data.leaves.push(node as u32);
        }
        data.topology.push(Topology { skip: tree.skip[node], parent: tree.parent[node], face });
    }
    data.triangles = faces.iter().map(|&face| mesh.triangles[face as usize]).collect();

    // The triangles around each vertex: count, prefix sum, fill.
    let mut starts = vec![0u32; mesh.positions.len() + 1];
    for vertex in data.triangles.iter().flatten() {
        starts[*vertex as usize + 1] += 1;
    }
    for vertex in 1..starts.len() {
        starts[vertex] += starts[vertex - 1];
    }
    let mut next = starts.clone();
    data.corners = vec![0; 3 * data.triangles.len()];
    for (face, triangle) in data.triangles.iter().enumerate() {
        for &vertex in triangle {
            data.corners[next[vertex as usize] as usize] = face as u32;
            next[vertex as usize] += 1;
        }
    }
    data.corner_starts = starts;
    faces
}

fn frame(state: &mut State, material: &Material, transport: &Transport, units: Units, local: Option<Local>) {
    let mut params = ObjectParams {
        next_node: state.data.topology.len() as u32,
        scene_nodes: state.data.topology.len() as u32,
        opaque: if material.opaque.is_some() { OPAQUE_BY_FACE } else { OPAQUE_NOT },
        vertices: state.data.positions.len() as u32,
        faces: state.data.triangles.len() as u32,
        nodes: state.data.topology.len() as u32,
        receiver_angle: transport.receiver_angle as f32,
        emitter_angle: transport.emitter_angle as f32,
        planarity: (transport.planarity * transport.planarity) as f32,
        kappa: if transport.curvature == Kappa::Mean { KAPPA_MEAN } else { KAPPA_RMS },
        link_error: link_error(transport.tolerance) as f32,
        ladder: Ladder::new(transport.form_factor_tolerance).chi.map(|chi| chi as f32),
        ..ObjectParams::default()
    };
    coefficients(&mut params, material, units, local);
    state.data.object_params = vec![params];
}

/// Builds the trees' schedules, for chunks of at most `faces` faces.
pub fn schedule(prepared: &mut Prepared, faces: usize) {
    let state = &mut prepared.state;
    state.data.order = vec![0; state.extent().nodes];
    for (object, tree) in state.objects.iter_mut().zip(&prepared.trees) {
        let (schedule, order) = Schedule::new(tree, faces);
        object.schedule = schedule;
        state.data.order[object.first.nodes..][..order.len()].copy_from_slice(&order);
    }
}
