//! From a checked scene to the state a frame starts from: centred, scaled, in the order of the tree.
//!
//! Inside a frame the object has unit extent and the brightest light gives an irradiance of about 1; both factors
//! are powers of two, so that nothing is lost on the way to `f32` and back.

use glam::DVec3;

use super::blocks::{blocks, edge_nodes, link_error, triangle_size};
use super::lights::{lights, radiance};
use super::textures::texture;
use crate::dipole::form_factor::ladder::Ladder;
use crate::dipole::profile::Dipole;
use crate::hierarchy::face_cluster::{self, Method};
use crate::hierarchy::{Tree, median};
use crate::layout::{Camera as CameraRecord, Frame, Topology};
use crate::light::{fresnel, harmonics};
use crate::scene::{Camera, Fresnel, Hierarchy, Material, Mesh, Reflection, Scene, Transport};
use crate::state::{Method as Switches, Schedule, Scheme, State};
use crate::transport::gather::PLACES;

/// How internal numbers relate to the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// The scene's point that is the internal origin.
    pub center: DVec3,
    /// Internal length of one scene unit.
    pub length: f64,
    /// Scene irradiance of an internal irradiance of 1.
    pub light: f64,
}

/// A state ready to run, and what is needed to read its results.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The state; lists have no room yet.
    pub state: State,
    /// Its units.
    pub units: Units,
    /// The tree.
    pub tree: Tree,
    /// How the tree came about.
    pub method: Method,
    /// The mesh's triangle of each triangle of the state.
    pub faces: Vec<u32>,
}

impl Units {
    /// For these positions; light stays as it is.
    fn of(positions: &[DVec3]) -> Self {
        let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element();
        let length = if extent.is_finite() && extent > 0.0 { (-extent.log2().ceil()).exp2() } else { 1.0 };
        let center = if extent.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO };
        Self { center, length, light: 1.0 }
    }

    /// A point of the scene inside the frame.
    pub fn inside(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.length
    }
}

pub(super) fn narrow(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// The largest reduced extinction inside a frame: a mean free path of a millionth of the object. Anything denser is
/// brought down to it with its albedo kept: light leaves where it enters, and `f32` positions say no more than that.
const DENSEST: f64 = 1e6;

/// The smallest: anything thinner is brought up to it. So little light comes back that none is seen, but powers of the
/// depths stay within `f32`.
const THINNEST: f64 = 1e-11;

/// The dipole of each channel in internal units.
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

/// Builds tree and state of a scene.
pub fn prepare(scene: &Scene) -> Prepared {
    let mesh = &scene.object.mesh;
    let (tree, method) = match scene.transport.hierarchy {
        Hierarchy::FaceClusters => face_cluster::build(&mesh.positions, &mesh.triangles),
        Hierarchy::Median => (median::build(&mesh.positions, &mesh.triangles, PLACES), Method::Merged),
    };
    let mut units = Units::of(&mesh.positions);
    let mut state = State { distance: scene.transport.distance, ..State::default() };
    let faces = topology(&mut state, mesh, &tree, units);
    frame(&mut state, &scene.object.material, &scene.transport, units);
    texture(&mut state, scene.object.material.texture.as_ref(), mesh, &faces);
    state.method = Switches {
        scheme: scene.transport.scheme,
        order: scene.transport.order,
        nodes: edge_nodes(scene.transport.tolerance, triangle_size(&state)),
        estimate: false,
        near: scene.transport.near,
    };
    if scene.transport.scheme == Scheme::Blocks {
        state.data.blocks = blocks(&state);
        state.data.frame[0].blocks = state.data.blocks.len() as u32;
    }
    lights(&mut state, &scene.lights, &mut units, mesh);
    camera(&mut state, &scene.camera, units);
    Prepared { state, units, tree, method, faces }
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
    let dipoles = dipoles(material, units.length);
    let of = |f: fn(&Dipole) -> f64| dipoles.each_ref().map(|dipole| f(dipole) as f32);
    let reflection = match material.surface.reflection {
        Reflection::None => (0, 0.0),
        Reflection::Phong { shininess } => (1, shininess as f32),
        Reflection::Ggx { roughness } => (2, roughness as f32),
    };
    let zonal = material.eta.map(harmonics::zonal);
    let degree = |l: usize| zonal.map(|factors| factors[l] as f32);
    state.data.frame = vec![Frame {
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
        link_error: link_error(transport.tolerance) as f32,
        ladder: Ladder::new(transport.form_factor_tolerance).chi.map(|chi| chi as f32),
        ..Frame::default()
    }];
}

/// Puts the camera in place.
pub fn camera(state: &mut State, camera: &Camera, units: Units) {
    let (right, up, forward) = camera.basis();
    let [width, height] = camera.size;
    let half = f64::tan(0.5 * camera.fov.to_radians());
    state.data.camera = vec![CameraRecord {
        origin: narrow(units.inside(camera.position)),
        right: narrow(right * half * f64::from(width) / f64::from(height)),
        up: narrow(up * half),
        forward: narrow(forward),
        width,
        height,
        shift_x: 0.0,
        shift_y: 0.0,
        background: camera.background.map(|x| x as f32),
        environment: u32::from(camera.environment),
        radiance: radiance(units),
    }];
}

/// The transport's distance convention and the tree's schedule, for chunks of at most `faces` faces.
pub fn schedule(prepared: &mut Prepared, faces: usize) {
    let (schedule, order) = Schedule::new(&prepared.tree, faces);
    prepared.state.schedule = schedule;
    prepared.state.data.order = order;
}
