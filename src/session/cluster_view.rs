//! A picture of the clusters that light one receiver, as in the paper's figure 6.9, coloured by tree level.

use std::collections::BTreeMap;

use glam::DVec3;

use super::curvature_view::lit_from_the_eye;
use super::run::Session;
use crate::error::{Input, Result};
use crate::layout::BufferId;
use crate::state::{Scheme, Scope, State, narrow, wide};
use crate::view::picture::Picture;

/// Linear colours from the finest level to the coarsest.
const FINE: DVec3 = DVec3::new(0.9, 0.12, 0.03);
const MIDDLE: DVec3 = DVec3::new(0.55, 0.6, 0.05);
const COARSE: DVec3 = DVec3::new(0.03, 0.2, 0.8);

/// The emitters of one receiver.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    /// The object.
    pub object: usize,
    /// By level, counted from the root: the number of emitters (clusters or triangles), and the triangles in them.
    pub levels: BTreeMap<usize, (usize, usize)>,
    /// For each of the object's triangles, its emitter and that emitter's level; none for a triangle that emits
    /// nothing.
    pub of_face: Vec<Option<(u32, usize)>>,
}

/// The clusters that light what a pixel shows, as a picture and by level, for the first group of channels. The
/// session keeps its lists (`Mode::Keep`) and has run a frame.
pub fn clusters(session: &mut Session, pick: [u32; 2]) -> Result<(Picture, Emitters)> {
    let lists = [
        BufferId::runs,
        BufferId::entries,
        BufferId::spans,
        BufferId::links,
        BufferId::blocks,
        BufferId::normals,
        BufferId::placed_normals,
        BufferId::placed_positions,
    ];
    session.fetch(&[BufferId::hits, BufferId::seen, BufferId::normals])?;
    session.fetch(&[BufferId::positions, BufferId::placed_positions, BufferId::placed_normals])?;
    session.fetch(&lists)?;
    let state = session.state();
    let data = &state.data;
    let [width, height] = [data.camera[0].width, data.camera[0].height];
    let fault = |what: &str| Input::new(what).key("--pick").found(format!("{},{}", pick[0], pick[1]));
    if pick[0] >= width || pick[1] >= height {
        let expected = format!("0 to {} and 0 to {}, counted from the upper left", width - 1, height - 1);
        return Err(fault("outside the picture").expected(expected).into());
    }
    let pixel = (pick[1] * width + pick[0]) as usize;
    let hit = data.hits[pixel];
    if hit.face as usize >= data.triangles.len() {
        return Err(fault("the pixel shows nothing").expected("a pixel that shows an object").into());
    }
    let object = state.object_of(hit.face as usize);
    if state.objects[object].opaque {
        return Err(fault("the pixel shows an opaque object").expected("a pixel that shows a translucent one").into());
    }
    let (nodes, receivers) = emitters(state, object, pixel, hit.face as usize);
    let emitters = cover(state, object, &nodes);
    Ok((paint(state, &emitters, &receivers), emitters))
}

/// The nodes that light the receiver, and the triangles to paint as the receiver.
fn emitters(state: &State, object: usize, pixel: usize, face: usize) -> (Vec<u32>, Vec<usize>) {
    let (data, part) = (&state.data, &state.objects[object]);
    let local = face - part.first.faces;
    if state.method.scheme == Scheme::Links {
        return (linked(state, object, data.leaves[face]), vec![local]);
    }
    let receiver = if part.by_pixel { data.seen[pixel] as usize } else { local };
    for (at, batch) in state.batches().filter(|(at, _)| at.object == object && at.group == 0) {
        for number in batch.clone() {
            let block = data.blocks[part.first.blocks + number as usize];
            let has = block.first as usize..(block.first + block.count) as usize;
            if has.contains(&receiver) {
                let run = data.runs[state.part(BufferId::runs, at).0 + (number - batch.start) as usize];
                let first = state.part(BufferId::entries, at).0 + run.first as usize;
                let count = run.expanded + run.direct + run.area + run.edge;
                let painted = if part.by_pixel { vec![local] } else { has.collect() };
                return (data.entries[first..first + count as usize].to_vec(), painted);
            }
        }
    }
    (Vec::new(), vec![local])
}

/// Emitters linked to a leaf and to all clusters that contain it.
fn linked(state: &State, object: usize, leaf: u32) -> Vec<u32> {
    let (data, part) = (&state.data, &state.objects[object]);
    let mut found = Vec::new();
    if data.spans.is_empty() {
        // There is no light.
        return found;
    }
    let mut node = leaf;
    while node != u32::MAX {
        let span = data.spans[part.first.nodes + node as usize];
        // A node is in one chunk; nodes at the top are in the first.
        let links = (0..part.schedule.chunks.len()).find_map(|chunk| {
            let (base, length) = state.part(BufferId::links, Scope { object, chunk, group: 0 });
            let links = data.links[base..base + length].get(span.link as usize..(span.link + span.links) as usize)?;
            links.iter().all(|link| link.receiver == node).then_some(links)
        });
        found.extend(links.into_iter().flatten().map(|link| link.emitter));
        node = data.topology[part.first.nodes + node as usize].parent;
    }
    found
}

/// Finds the emitter of each triangle.
fn cover(state: &State, object: usize, nodes: &[u32]) -> Emitters {
    let (data, part) = (&state.data, &state.objects[object]);
    let tree = &data.topology[part.first.nodes..part.first.nodes + part.count.nodes];
    let mut levels = BTreeMap::new();
    let mut of_face = vec![None; part.count.faces];
    for &emitter in nodes {
        let mut level = 0;
        let mut node = emitter;
        while tree[node as usize].parent != u32::MAX {
            node = tree[node as usize].parent;
            level += 1;
        }
        let inside = &tree[emitter as usize..tree[emitter as usize].skip as usize];
        let (clusters, triangles) = levels.entry(level).or_insert((0, 0));
        *clusters += 1;
        for leaf in inside.iter().filter(|node| node.face != u32::MAX) {
            *triangles += 1;
            of_face[leaf.face as usize] = Some((emitter, level));
        }
    }
    Emitters { object, levels, of_face }
}

/// The colour of a level.
pub fn color(emitters: &Emitters, level: usize) -> [f32; 3] {
    let ends = emitters.levels.keys().next().zip(emitters.levels.keys().next_back());
    let (&coarsest, &finest) = ends.unwrap_or((&0, &0));
    let t = (level - coarsest) as f64 / (finest - coarsest).max(1) as f64;
    narrow(if t < 0.5 { COARSE.lerp(MIDDLE, 2.0 * t) } else { MIDDLE.lerp(FINE, 2.0 * t - 1.0) })
}

/// Paints levels as colours, clusters as shades of them, the receiver white, everything else grey; lit from the eye.
fn paint(state: &State, emitters: &Emitters, receivers: &[usize]) -> Picture {
    let first = state.objects[emitters.object].first.faces;
    lit_from_the_eye(state, |hit, _| {
        let inside = state.object_of(hit.face as usize) == emitters.object;
        match inside.then(|| hit.face as usize - first) {
            Some(face) if receivers.contains(&face) => DVec3::ONE,
            Some(face) => emitters.of_face[face].map_or(DVec3::splat(0.05), |(node, level)| {
                let shade = f64::from(node.wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
                (0.55 + 0.45 * shade) * wide(color(emitters, level))
            }),
            None => DVec3::splat(0.02),
        }
    })
}
