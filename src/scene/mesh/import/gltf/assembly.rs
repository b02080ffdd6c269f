//! All primitives of a scene together: vertices as their nodes have them, and the matrices that place them.

use super::document::{Document, gone};
use super::primitive::{self, Piece};
use super::tree::{Local, Tree};
use super::{Checked, Files, Input, LARGEST};
use crate::scene::mesh::import::unread;
use crate::scene::skin::{Pose, Rig};
use glam::{DMat3, DMat4, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::texture::Info;
use gltf::json::validation::Checked::Valid;
use std::collections::HashMap;

/// Memory per vertex and triangle, bytes.
const BYTES: u64 = 300;

/// Meshes joined into one.
#[derive(Default)]
pub(super) struct Assembly<'a> {
    /// Vertices in the frames of their nodes, with morph targets.
    pub base: Vec<DVec3>,
    /// The matrices that place each vertex, and their weights: `count` a vertex.
    pub influences: Vec<(u32, f64)>,
    /// Influences of a vertex.
    pub count: usize,
    /// Matrices from the frames of nodes, or of bound joints, to the scene.
    pub matrices: Vec<DMat4>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Primitives in order.
    pub pieces: Vec<Placed<'a>>,
}

/// A primitive among those that are joined.
pub(super) struct Placed<'a> {
    /// The primitive in the file.
    pub primitive: &'a Primitive,
    /// The number of its first vertex.
    pub first: u32,
    /// Its contents.
    pub piece: Piece,
    /// The weights of its morph targets.
    pub weights: Vec<f64>,
}

/// Primitives with triangles of the nodes that are shown.
pub(super) fn primitives<'a>(document: &'a Document, tree: &Tree) -> Checked<Vec<(usize, &'a Primitive)>> {
    let mut all = Vec::new();
    for node in tree.shown() {
        let Some(mesh) = document.root.nodes[node].mesh.map(|mesh| mesh.value()) else { continue };
        let mesh = document.root.meshes.get(mesh).ok_or_else(|| gone("mesh", mesh))?;
        let faces = |primitive: &&Primitive| {
            let mode = matches!(primitive.mode, Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan));
            mode && primitive.attributes.contains_key(&Valid(Semantic::Positions))
        };
        all.extend(mesh.primitives.iter().filter(faces).map(|primitive| (node, primitive)));
    }
    Ok(all)
}

impl<'a> Assembly<'a> {
    /// The primitives of these materials, with nodes posed by `locals`.
    pub fn of(
        document: &'a Document,
        files: &Files,
        tree: &Tree,
        locals: &[Local],
        materials: &[Option<usize>],
    ) -> Checked<Self> {
        let world = tree.world(locals);
        let mut whole = Self { count: 1, ..Self::default() };
        let mut pieces = Vec::new();
        let mut placed: HashMap<(bool, usize), u32> = HashMap::new();
        let mut size = 0;
        for (node, primitive) in primitives(document, tree)? {
            if !materials.contains(&primitive.material.map(|material| material.value())) {
                continue;
            }
            let Some(piece) = Piece::read(document, files, primitive)? else { continue };
            size += (piece.positions.len() + piece.joints.len() / 4 + piece.triangles.len()) as u64;
            files.need(size * BYTES).map_err(|error| unread(&error))?;
            let skin = document.root.nodes[node].skin.map(|skin| skin.value()).filter(|_| piece.joint_count > 0);
            let key = (skin.is_some(), skin.unwrap_or(node));
            let first = match placed.get(&key) {
                Some(first) => *first,
                None => {
                    let matrices = match skin {
                        Some(skin) => bound(document, files, skin, &world)?,
                        None => vec![world[node]],
                    };
                    let first = whole.matrices.len() as u32;
                    whole.matrices.extend(matrices);
                    *placed.entry(key).or_insert(first)
                }
            };
            whole.count = whole.count.max(if skin.is_some() { piece.joint_count } else { 1 });
            pieces.push((node, primitive, piece, skin.is_some(), first));
        }
        for (node, primitive, piece, skinned, first) in pieces {
            whole.add(primitive, piece, &locals[node].weights, skinned, first)?;
        }
        Ok(whole)
    }

    /// Adds a primitive. If it is `skinned`, its joints are the matrices from `first` on, else matrix `first` places
    /// it.
    fn add(
        &mut self,
        primitive: &'a Primitive,
        piece: Piece,
        weights: &[f64],
        skinned: bool,
        first: u32,
    ) -> Checked<()> {
        let start = u32::try_from(self.base.len()).ok();
        let start = start.filter(|start| start.checked_add(piece.positions.len() as u32).is_some());
        let Some(start) = start else {
            return Err(Input::new("the mesh has too many vertices").expected("below 2^32"));
        };
        for vertex in 0..piece.positions.len() {
            self.base.push(piece.morphed(vertex, weights));
            let influences = match skinned {
                true => &piece.joints[vertex * piece.joint_count..][..piece.joint_count],
                false => &[(0, 1.0)],
            };
            for k in 0..self.count {
                let (joint, weight) = influences.get(k).copied().unwrap_or_default();
                let matrix = first.saturating_add(if weight == 0.0 { 0 } else { joint });
                if matrix as usize >= self.matrices.len() {
                    return Err(Input::new("a vertex names a joint that its skin does not have").found(joint));
                }
                self.influences.push((matrix, weight));
            }
        }
        // A mirrored node turns its triangles around.
        let mirrored = !skinned && self.matrices[first as usize].determinant() < 0.0;
        let turn = |[a, b, c]: [u32; 3]| if mirrored { [b, a, c] } else { [a, b, c] };
        self.triangles.extend(piece.triangles.iter().map(|corners| turn(corners.map(|corner| start + corner))));
        self.pieces.push(Placed { primitive, first: start, piece, weights: weights.to_vec() });
        Ok(())
    }

    /// Where the vertices are in the scene: the mean, by weight, of where their matrices place them.
    pub fn positions(&self) -> impl Iterator<Item = DVec3> {
        let place = |(base, influences): (&DVec3, &[(u32, f64)])| {
            let used = influences.iter().filter(|(_, weight)| *weight != 0.0);
            used.map(|&(matrix, weight)| weight * self.matrices[matrix as usize].transform_point3(*base)).sum()
        };
        self.base.iter().zip(self.influences.chunks_exact(self.count)).map(place)
    }

    /// Texture coordinates of the triangles' corners; none unless every primitive has some.
    pub fn uvs(&self, document: &Document, files: &Files, info: Option<&Info>) -> Checked<Option<Vec<[[f64; 2]; 3]>>> {
        let mut all = Vec::with_capacity(self.base.len());
        for Placed { primitive, piece, .. } in &self.pieces {
            let Some(uvs) = primitive::uvs(document, files, primitive, info)? else { return Ok(None) };
            if uvs.len() != piece.positions.len() {
                return Err(Input::new("attribute TEXCOORD has not one entry per vertex").found(uvs.len()));
            }
            all.extend(uvs);
        }
        Ok(Some(self.triangles.iter().map(|corners| corners.map(|corner| all[corner as usize])).collect()))
    }

    /// Normals of the triangles' corners, turned by their matrices; 0 for a primitive that has none that can be read,
    /// or that morph targets change. None if all are such.
    pub fn normals(&self, document: &Document, files: &Files) -> Option<Vec<[DVec3; 3]>> {
        let mut all = Vec::with_capacity(self.base.len());
        for Placed { primitive, piece, weights, .. } in &self.pieces {
            let morphed = !piece.targets.is_empty() && weights.iter().any(|weight| *weight != 0.0);
            let own = if morphed { None } else { primitive::normals(document, files, primitive).unwrap_or_default() };
            let none = || vec![DVec3::ZERO; piece.positions.len()];
            all.extend(own.filter(|own| own.len() == piece.positions.len()).unwrap_or_else(none));
        }
        // The matrix of cofactors keeps a normal perpendicular; a mirror turns it over.
        let turned = |matrix: usize, normal: DVec3| {
            let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_mat4(self.matrices[matrix]);
            DMat3::from_cols(y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis)) * normal
        };
        for (normal, influences) in all.iter_mut().zip(self.influences.chunks_exact(self.count)) {
            let of = |&(matrix, weight): &(u32, f64)| weight * turned(matrix as usize, *normal).normalize_or_zero();
            *normal = influences.iter().map(of).sum();
        }
        let some = all.iter().any(|normal| *normal != DVec3::ZERO);
        some.then(|| self.triangles.iter().map(|corners| corners.map(|corner| all[corner as usize])).collect())
    }

    /// The rig of these vertices: each piece has a row of weights.
    pub fn rig(&self, vertices: &[u32]) -> Checked<Rig> {
        let targets = self.targets();
        if targets > Rig::MOST_TARGETS || self.count > Rig::MOST_JOINTS {
            let found = format!("{targets} targets and {} joints of a vertex", self.count);
            let fault = Input::new("too many morph targets or joints").found(found);
            return Err(fault.expected(format!("at most {} and {}", Rig::MOST_TARGETS, Rig::MOST_JOINTS)));
        }
        let mut rig = Rig { joints: self.count, targets, ..Rig::default() };
        for &vertex in vertices {
            let row = self.pieces.partition_point(|placed| placed.first <= vertex).saturating_sub(1);
            let Placed { piece, first, .. } = &self.pieces[row];
            let local = (vertex - first) as usize;
            rig.base.push(piece.positions[local]);
            rig.influences.extend(&self.influences[vertex as usize * self.count..][..self.count]);
            let way = |k: usize| piece.targets.get(k).and_then(|target| target.get(local)).copied().unwrap_or_default();
            rig.ways.extend((0..targets).map(way));
            rig.rows.push(row as u32);
        }
        Ok(rig)
    }

    /// The pose in which the nodes are.
    pub fn pose(&self) -> Pose {
        let targets = self.targets();
        let row = |placed: &Placed<'_>| -> Vec<f64> {
            (0..targets).map(|k| placed.weights.get(k).copied().unwrap_or_default()).collect()
        };
        Pose { matrices: self.matrices.clone(), weights: self.pieces.iter().flat_map(row).collect() }
    }

    fn targets(&self) -> usize {
        self.pieces.iter().map(|placed| placed.piece.targets.len()).max().unwrap_or(0)
    }

    /// The lowest and highest corner of the bounding box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let used: Vec<bool> =
            self.triangles.iter().flatten().fold(vec![false; self.base.len()], |mut used, &corner| {
                used[corner as usize] = true;
                used
            });
        let places = self.positions().zip(used).filter(|(p, used)| *used && p.abs().max_element() <= LARGEST);
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        places.fold(start, |(low, high), (p, _)| (low.min(p), high.max(p)))
    }
}

/// For each joint of a skin, the matrix to the scene from the frame in which vertices are bound.
fn bound(document: &Document, files: &Files, skin: usize, world: &[DMat4]) -> Checked<Vec<DMat4>> {
    let skin = document.root.skins.get(skin).ok_or_else(|| gone("skin", skin))?;
    let inverse = match skin.inverse_bind_matrices {
        Some(index) => {
            document.vectors::<16>(files, index.value())?.iter().map(DMat4::from_cols_array).collect::<Vec<_>>()
        }
        None => vec![DMat4::IDENTITY; skin.joints.len()],
    };
    if inverse.len() < skin.joints.len() {
        let fault = Input::new("a skin has fewer inverse bind matrices than joints").found(inverse.len());
        return Err(fault.expected(skin.joints.len()));
    }
    let to_scene =
        |(joint, inverse): (usize, DMat4)| Ok(*world.get(joint).ok_or_else(|| gone("node", joint))? * inverse);
    skin.joints.iter().map(|joint| joint.value()).zip(inverse).map(to_scene).collect()
}
