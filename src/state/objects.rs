//! Several objects in one state. Each object has its own range of elements in every buffer, found by [`State::part`],
//! and can be extracted as a state of its own. Ranges begin at multiples of 64 elements, so that a device can bind
//! any of them.

use super::{Group, Schedule, Scope, State};
use crate::layout::{BUFFER_IDS, BufferId, ObjectParams, Partition};

/// How many elements of each kind an object has, or the indices of its first ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Nodes.
    pub nodes: usize,
    /// Blocks of receivers.
    pub blocks: usize,
    /// Receivers: triangles, or points that pixels show.
    pub receivers: usize,
}

/// One object of a state.
#[derive(Clone, Debug, Default)]
pub struct Object {
    /// The order of the work on its tree.
    pub schedule: Schedule,
    /// The groups of channels that are carried together; a black channel is in none.
    pub groups: Vec<Group>,
    /// Indices of its first elements.
    pub first: Extent,
    /// Numbers of its elements.
    pub count: Extent,
    /// Whether no light enters it.
    pub opaque: bool,
    /// Where incident light is evaluated if the object is opaque.
    pub lit_at: LitAt,
    /// Whether its receivers are the points that pixels show, 16 per tile of 4 x 4 pixels.
    pub by_pixel: bool,
    /// Whether it has layers beneath its surface.
    pub layered: bool,
    /// How many vectors its Krylov space has at most: above 0 where a system of equations is solved.
    pub vectors: usize,
    /// Whether pictures show the light that its medium scatters once.
    pub scatters_once: bool,
    /// How many deformations it has.
    pub deforms: usize,
    /// Whether its vertex normals are those of the whole long triangles, which were divided.
    pub whole_normals: bool,
    /// Whether its vertices follow joints.
    pub skinned: bool,
    /// Whether it, or any other object, lies elsewhere in the scene than in its own frame.
    pub placed: bool,
}

/// Where light incident on an opaque object is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LitAt {
    /// At its triangles.
    #[default]
    Faces,
    /// At the points that pixels show.
    Pixels,
    /// At both: pixels for the picture, triangles for the layers of face data beside it.
    Both,
}

/// The next multiple of 64.
fn padded(count: usize) -> usize {
    count.next_multiple_of(64)
}

impl Object {
    /// Whether it is opaque and lit per pixel.
    pub fn plain(&self) -> bool {
        self.opaque && self.lit_at != LitAt::Faces
    }

    /// Whether a system of equations is solved for it: diffusion.
    pub fn solves(&self) -> bool {
        self.vectors > 0
    }

    /// Whether the light at its triangles is needed.
    pub fn lit_by_face(&self) -> bool {
        !self.opaque || self.lit_at != LitAt::Pixels
    }

    /// The object's range in a buffer, its first element and the number of elements; `words` is the number of shadow
    /// words per triangle.
    pub(super) fn run(&self, partition: Partition, words: usize) -> (usize, usize) {
        let (first, count) = (self.first, self.count);
        match partition {
            Partition::Vertex => (first.vertices, count.vertices),
            Partition::Start => (first.vertices, count.vertices + 1),
            Partition::Face => (first.faces, count.faces),
            Partition::Corner => (3 * first.faces, 3 * count.faces),
            Partition::Shadow => (words * first.faces, words * count.faces),
            Partition::Node => (first.nodes, count.nodes),
            Partition::Receiver => (first.receivers, count.receivers),
            _ => (first.blocks, count.blocks),
        }
    }

    /// Elements that it takes in the buffer of its Krylov space.
    pub fn of_vectors(&self) -> usize {
        self.vectors * padded(self.count.faces)
    }

    /// Elements that each group of channels has in the buffers of moments.
    pub(super) fn of_group(&self) -> usize {
        padded(self.count.nodes)
    }
}

impl State {
    /// The object of a scope.
    pub fn object(&self, at: Scope) -> &Object {
        &self.objects[at.object]
    }

    /// The order of the moments of an object's clusters; diffusion needs the second.
    pub fn moment_order(&self, at: Scope) -> u32 {
        if self.object(at).solves() { 2 } else { self.method.order }
    }

    /// Whether an object's lists serve any light: those of diffusion always do.
    pub fn any_light(&self, at: Scope) -> bool {
        self.method.any_light || self.object(at).solves()
    }

    /// The object of a triangle, given the triangle's index over all objects.
    pub fn object_of(&self, face: usize) -> usize {
        self.objects.iter().rposition(|object| object.first.faces <= face).unwrap_or(0)
    }

    /// Every triangle and its leaf, both as indices over all objects.
    pub fn faces(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.objects.iter().flat_map(move |object| {
            let (first, nodes) = (object.first.faces, object.first.nodes);
            (first..first + object.count.faces).map(move |face| (face, nodes + self.data.leaves[face] as usize))
        })
    }

    /// Number of elements of each kind over all objects, gaps included.
    pub fn extent(&self) -> Extent {
        self.objects.last().map_or_else(Extent::default, |Object { first, count, .. }| Extent {
            vertices: first.vertices + count.vertices,
            faces: first.faces + count.faces,
            nodes: first.nodes + count.nodes,
            blocks: first.blocks + count.blocks,
            receivers: first.receivers + count.receivers,
        })
    }

    /// Pixels of the picture; none where there is no camera.
    pub fn pixels(&self) -> usize {
        self.data.camera.first().map_or(0, |camera| camera.width as usize * camera.height as usize)
    }

    /// Whether any light shines: one with a positive colour, or an environment.
    pub fn lit(&self) -> bool {
        self.data.lights.iter().any(|light| light.color.iter().any(|&x| x > 0.0)) || !self.data.sky.is_empty()
    }

    /// The sum of `count` over all objects.
    pub fn sum(&self, count: impl Fn(&Object) -> usize) -> usize {
        self.objects.iter().map(count).sum()
    }

    /// Joins states of one object each: their vertices, triangles, trees and blocks. Lists and results are still
    /// empty.
    pub fn join(states: Vec<Self>) -> Self {
        let mut joined = Self::default();
        let mut first = Extent::default();
        for state in states {
            if joined.objects.is_empty() {
                joined = Self { data: Default::default(), objects: Vec::new(), ..state.clone() };
            }
            let mut object = state.objects.into_iter().next().unwrap_or_default();
            object.first = first;
            // Triangles index the joined vertices, gaps included; positions get the same gaps as all other vertex
            // data.
            let corner = first.vertices as u32;
            joined.data.positions.resize(first.vertices, [0.0; 3]);
            joined.data.positions.extend(&state.data.positions);
            let texel = joined.data.texels.len() as u32;
            joined.data.texels.extend(&state.data.texels);
            joined.data.object_params.extend(state.data.object_params.iter().map(|params| {
                let texture_first = params.texture_first + if params.texture_side > 0 { texel } else { 0 };
                let sigma_0_first = params.sigma_0_first + if params.sigma_0_size[0] > 0 { texel } else { 0 };
                ObjectParams { texture_first, sigma_0_first, ..*params }
            }));
            for &id in BUFFER_IDS {
                let (partition, have) = (id.spec().partition, state.data.bytes(id));
                if matches!(
                    partition,
                    Partition::Whole
                        | Partition::Object
                        | Partition::Small
                        | Partition::Vectors
                        | Partition::Group
                        | Partition::Chunk
                        | Partition::Batch
                ) || have.is_empty()
                {
                    continue;
                }
                let (first, count) = object.run(partition, 0);
                joined.data.resize(id, first + count);
                joined.data.bytes_mut(id)[first * id.spec().stride..].copy_from_slice(have);
            }
            for vertex in joined.data.triangles[first.faces..].iter_mut().flatten() {
                *vertex += corner;
            }
            first = Extent {
                vertices: first.vertices + padded(object.count.vertices + 1),
                faces: first.faces + padded(object.count.faces),
                nodes: first.nodes + padded(object.count.nodes),
                blocks: first.blocks + padded(object.count.blocks),
                receivers: first.receivers + padded(object.count.receivers),
            };
            joined.objects.push(object);
        }
        let nodes = joined.extent().nodes as u32;
        for (k, params) in joined.data.object_params.iter_mut().enumerate() {
            let first = joined.objects[k].first;
            [params.first_vertex, params.first_face, params.first_node, params.first_receiver] =
                [first.vertices, first.faces, first.nodes, first.receivers].map(|n| n as u32);
            params.next_node = joined.objects.get(k + 1).map_or(nodes, |next| next.first.nodes as u32);
            params.scene_nodes = nodes;
        }
        joined
    }

    /// One object's part of every buffer, as a state of that object alone.
    pub fn alone(&self, number: usize) -> Self {
        let object = Object { first: Extent::default(), ..self.objects[number].clone() };
        let mut alone = Self { data: Default::default(), objects: vec![object], ..*self };
        for &id in BUFFER_IDS {
            let (stride, (first, count)) = (id.spec().stride, self.parts(id, number));
            alone.data.clear(id, count);
            alone.data.bytes_mut(id).copy_from_slice(&self.data.bytes(id)[first * stride..(first + count) * stride]);
        }
        alone
    }

    /// Copies these buffers back from a state made by [`Self::alone`].
    pub fn take(&mut self, number: usize, alone: &Self, ids: impl IntoIterator<Item = BufferId>) {
        for id in ids {
            let (stride, (first, count)) = (id.spec().stride, self.parts(id, number));
            self.data.bytes_mut(id)[first * stride..(first + count) * stride].copy_from_slice(alone.data.bytes(id));
        }
    }
}
