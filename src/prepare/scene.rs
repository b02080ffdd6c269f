//! From a checked scene to the state a frame starts from: centred, scaled, in the order of the trees.

use glam::DVec3;

use super::blocks::{blocks, edge_nodes, link_error, of_picture, triangle_size};
use super::camera::camera;
use super::layers::layers;
use super::lights::lights;
use super::shading;
use super::shape::{shape, spoilt};
use super::textures::texture;
use super::units::Units;
use crate::dipole::form_factor::ladder::Ladder;
use crate::dipole::profile::Dipole;
use crate::hierarchy::face_cluster::{self, Method};
use crate::hierarchy::{Tree, median, split};
use crate::layout::{
    KAPPA_MEAN, KAPPA_RMS, OPAQUE_BY_FACE, OPAQUE_BY_PIXEL, OPAQUE_NOT, ObjectParams, REFLECTION_GGX, REFLECTION_NONE,
    REFLECTION_PHONG, Topology,
};
use crate::lighting::{fresnel, harmonics};
use crate::scene::{self, DENSEST, Fresnel, Hierarchy, Kappa, Material, Mesh, Reflection, Scene, Side, Transport};
use crate::state::{Extent, LitAt, Local, Method as Switches, Object, Schedule, Scheme, State, narrow};
use crate::transport::blocks::BLOCK_RECEIVERS;
use crate::view::pixel_receivers::LAYERS;

/// A state ready to run, and what is needed to read its results.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The state; lists have no capacity yet.
    pub state: State,
    /// Its units.
    pub units: Units,
    /// The tree of each object.
    pub trees: Vec<Tree>,
    /// How the trees came about, the worst of them.
    pub method: Method,
    /// Of each object whose deformations would spoil the tree of its shape at rest, so that it has one of its own: how
    /// much wider the clusters would be.
    pub spoilt: Vec<Option<f64>>,
    /// Of each object, the mesh's triangle of each triangle of the state.
    pub faces: Vec<Vec<u32>>,
    /// What became of the depth maps of objects that have any.
    pub maps: Vec<String>,
}

impl Prepared {
    /// The object and its mesh's triangle of a triangle of the state.
    pub fn source(&self, face: usize) -> (usize, u32) {
        let object = self.state.object_of(face);
        (object, self.faces[object][face - self.state.objects[object].first.faces])
    }

    /// The triangle of the state of each triangle of all meshes, one after the other.
    pub fn all_places(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.faces.len()).flat_map(|object| self.places(object))
    }

    /// The triangle of the state of each triangle of an object's mesh.
    pub fn places(&self, object: usize) -> Vec<usize> {
        let first = self.state.objects[object].first.faces;
        let mut places = vec![0; self.faces[object].len()];
        for (place, &face) in self.faces[object].iter().enumerate() {
            places[face as usize] = first + place;
        }
        places
    }
}

/// The smallest reduced extinction inside a frame: anything thinner is brought up to it. So little light comes back
/// that none is seen, but powers of the depths stay within `f32`.
const THINNEST: f64 = 1e-11;

/// The dipole of each channel in internal units. What is denser than [`DENSEST`] is brought down to it with its albedo
/// kept: light leaves where it enters, and `f32` positions say no more than that.
pub fn dipoles(material: &Material, length: f64) -> [Dipole; 3] {
    std::array::from_fn(|channel| {
        let eta = material.eta[channel];
        let inner = match material.fresnel {
            Fresnel::Exact => fresnel::diffuse_internal_exact(eta),
            Fresnel::Paper => fresnel::diffuse_internal_polynomial(eta),
        };
        let (scattering, absorption) = (material.sigma_s_prime[channel], material.sigma_a[channel]);
        let limit = |extinction: f64| extinction * length / (scattering + absorption);
        let change = limit(DENSEST).min(1.0).max(limit(THINNEST));
        let coefficient = |value: f64| value * change / length;
        Dipole::new(coefficient(scattering), coefficient(absorption), fresnel::boundary(inner))
    })
}

/// Builds trees and state of a scene, `by_pixel` with receivers where the pixels show its objects, and where light is
/// looked at that arrives at opaque ones.
///
/// With `local`, what comes back depends on the place alone: there are no receivers, and a texture is looked at once.
pub fn prepare(scene: &Scene, (by_pixel, lit_at): (bool, LitAt), local: Option<Local>) -> Prepared {
    let mut units = Units::of(scene.objects.iter().map(|object| &object.mesh));
    let (mut parts, mut trees, mut method) = (Vec::new(), Vec::new(), Method::Merged);
    let (mut faces, mut spoilt, mut largest) = (Vec::new(), Vec::new(), 0.0);
    for object in &scene.objects {
        let (tree, made, growth) = tree_of(object, scene.transport.hierarchy, units);
        let (part, own) = one(scene, object, &tree, units, (by_pixel, lit_at, local));
        spoilt.push(growth);
        if object.material.opaque.is_none() {
            largest = f64::max(largest, triangle_size(&part));
        }
        method = if made == Method::Merged { method } else { made };
        parts.push(part);
        trees.push(tree);
        faces.push(own);
    }
    let mut state = State::join(parts);
    state.method.nodes = edge_nodes(scene.transport.tolerance, largest);
    shape(&mut state, &scene.objects, units);
    let maps = layers(&mut state, &scene.objects, &faces, units);
    lights(&mut state, &scene.lights, &mut units, &scene.objects);
    camera(&mut state, &scene.camera, units);
    Prepared { state, units, trees, method, spoilt, faces, maps }
}

/// The tree of an object, how it came about, and how far deformations would have spoilt that of its shape at rest.
fn tree_of(object: &scene::Object, hierarchy: Hierarchy, units: Units) -> (Tree, Method, Option<f64>) {
    let build = |positions: &[DVec3]| match hierarchy {
        Hierarchy::FaceClusters => face_cluster::build(positions, &object.mesh.triangles),
        Hierarchy::Median => (median::build(positions, &object.mesh.triangles, BLOCK_RECEIVERS), Method::Merged),
        Hierarchy::Butterfly | Hierarchy::ShrinkWrap => {
            split::build(positions, &object.mesh.triangles, &object.mesh.splits)
        }
    };
    let (tree, method) = build(&object.mesh.positions);
    match spoilt(object, hierarchy, units, &tree) {
        None => (tree, method, None),
        Some((moved, growth)) => {
            let (tree, method) = build(&moved);
            (tree, method, Some(growth))
        }
    }
}

/// The state of one object by itself, and the mesh's triangle of each of its own.
fn one(
    scene: &Scene,
    object: &scene::Object,
    tree: &Tree,
    units: Units,
    (by_pixel, lit_at, local): (bool, LitAt, Option<Local>),
) -> (State, Vec<u32>) {
    let (mesh, transport) = (&object.mesh, &scene.transport);
    let mut state = State { distance: transport.distance, ..State::default() };
    let faces = topology(&mut state, mesh, tree, units);
    frame(&mut state, &object.material, transport, units);
    let mut material = object.material.clone();
    // What lies in layers under a surface is shown as its triangles are lit.
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
    // Only the CDRF asks how far light spreads.
    material.sigma_0_texture =
        material.sigma_0_texture.filter(|_| matches!(local, Some(Local::Closed | Local::Table(_))));
    state.method = Switches {
        scheme: transport.scheme,
        order: transport.order,
        estimate: false,
        near: transport.near,
        local,
        ..Switches::default()
    };
    texture(&mut state, &material, mesh, &faces);
    if transport.scheme == Scheme::Blocks && !opaque && local.is_none() {
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
    state.objects = vec![Object { count, opaque, lit_at, by_pixel, ..Object::default() }];
    (state, faces)
}

/// Mesh and tree, triangles in the order of the leaves; returns each one's place in the mesh.
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

    // The triangles round each vertex: count, add up, fill.
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

fn frame(state: &mut State, material: &Material, transport: &Transport, units: Units) {
    // What no light enters has no dipole.
    let dipoles = material.opaque.is_none().then(|| dipoles(material, units.length));
    let of = |f: fn(&Dipole) -> f64| dipoles.as_ref().map_or([0.0; 3], |d| d.each_ref().map(|dipole| f(dipole) as f32));
    let reflection = match material.surface.reflection {
        Reflection::None => (REFLECTION_NONE, 0.0),
        Reflection::Phong { shininess } => (REFLECTION_PHONG, shininess as f32),
        Reflection::Ggx { roughness } => (REFLECTION_GGX, roughness as f32),
    };
    let (sigma_0, diffuse) = shading::coefficients(material, dipoles.as_ref());
    let zonal = material.eta.map(harmonics::zonal);
    let degree = |l: usize| zonal.map(|factors| factors[l] as f32);
    state.data.object_params = vec![ObjectParams {
        next_node: state.data.topology.len() as u32,
        scene_nodes: state.data.topology.len() as u32,
        opaque: if material.opaque.is_some() { OPAQUE_BY_FACE } else { OPAQUE_NOT },
        albedo: material.opaque.unwrap_or_default().map(|share| share as f32),
        vertices: state.data.positions.len() as u32,
        faces: state.data.triangles.len() as u32,
        nodes: state.data.topology.len() as u32,
        receiver_angle: transport.receiver_angle as f32,
        emitter_angle: transport.emitter_angle as f32,
        planarity: (transport.planarity * transport.planarity) as f32,
        strength: of(|d| d.strength),
        sigma: of(|d| d.sigma),
        z_real: of(|d| d.z_real),
        z_virtual: of(|d| d.z_virtual),
        eta: material.eta.map(|eta| eta as f32),
        reflection: reflection.0,
        roughness: reflection.1,
        exit: material.eta.map(|eta| if material.surface.normalize_exit { fresnel::exit(eta) as f32 } else { 1.0 }),
        two_sided: u32::from(material.two_sided),
        zonal_0: degree(0),
        zonal_1: degree(1),
        zonal_2: degree(2),
        // A number in `f32`, too; times a curvature of 0 it is 0.
        sigma_0: sigma_0
            .map(|sigma| (sigma * if material.sigma_0.is_some() { units.length } else { 1.0 }).min(1e30) as f32),
        diffuse: diffuse.map(|share| share as f32),
        kappa: if transport.curvature == Kappa::Mean { KAPPA_MEAN } else { KAPPA_RMS },
        link_error: link_error(transport.tolerance) as f32,
        ladder: Ladder::new(transport.form_factor_tolerance).chi.map(|chi| chi as f32),
        ..ObjectParams::default()
    }];
}

/// The trees' schedules, for chunks of at most `faces` faces.
pub fn schedule(prepared: &mut Prepared, faces: usize) {
    let state = &mut prepared.state;
    state.data.order = vec![0; state.extent().nodes];
    for (object, tree) in state.objects.iter_mut().zip(&prepared.trees) {
        let (schedule, order) = Schedule::new(tree, faces);
        object.schedule = schedule;
        state.data.order[object.first.nodes..][..order.len()].copy_from_slice(&order);
    }
}
