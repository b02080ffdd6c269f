//! Scheme blocks: the blocks and channel groups of a scene, and the settings for a tolerance.

use super::textures::{brightest_entry, keeps_ratio};
use crate::dipole::form_factor::points::trace;
use crate::layout::{Block, ObjectParams};
use crate::scene::Light;
use crate::state::{Group, State, wide};
use crate::transport::blocks::BLOCK_RECEIVERS;
use crate::view::pixel_receivers::{LAYERS, tiles};

/// The largest subtrees of at most 16 faces, in tree order.
pub(crate) fn blocks(state: &State) -> Vec<Block> {
    let topology = &state.data.topology;
    let mut blocks = Vec::new();
    let mut node = 0;
    while node < topology.len() {
        let skip = topology[node].skip as usize;
        let count = (skip - node).div_ceil(2);
        if count > BLOCK_RECEIVERS {
            node += 1;
            continue;
        }
        let first = blocks.last().map_or(0, |last: &Block| last.first + last.count);
        blocks.push(Block { node: node as u32, first, count: count as u32 });
        node = skip;
    }
    blocks
}

/// Blocks for a picture of this size, to be filled by stage `pixel_receivers`.
pub(crate) fn of_picture(size: [u32; 2]) -> Vec<Block> {
    vec![Block::default(); (LAYERS * tiles(size)) as usize]
}

/// An object's triangle size, at rest, relative to the diffusion length: the largest sigma times the root of the mean
/// trace of second moments.
pub(crate) fn triangle_size(state: &State, number: usize) -> f64 {
    let (data, object) = (&state.data, &state.objects[number]);
    let rest = if data.rest.is_empty() { &data.positions } else { &data.rest };
    let spread = |corners: &[u32; 3]| trace(&corners.map(|v| wide(rest[v as usize])));
    let triangles = &data.triangles[object.first.faces..][..object.count.faces];
    let mean = triangles.iter().map(spread).sum::<f64>() / triangles.len().max(1) as f64;
    data.object_params[number].sigma.map(f64::from).into_iter().fold(0.0, f64::max) * mean.sqrt()
}

/// Quadrature nodes per edge in the edge form. Errors of neighbours partly cancel, so that a loose tolerance needs
/// few. A large triangle receives most of its light from itself, and nothing cancels.
pub(crate) fn edge_nodes(tolerance: f64, triangle_size: f64) -> u32 {
    match tolerance {
        t if t >= 5e-3 * triangle_size.clamp(1.0, 4.0) => 3,
        t if t >= 2e-4 => 6,
        _ => 12,
    }
}

/// The largest error of a link for a tolerance, in units of the reference level.
///
/// A solution's error falls more slowly than that of its links, whose errors partly cancel. The table was measured:
/// these values met their tolerance on the built-in scenes and five other meshes, from 1 to 1000 mm, ketchup to whole
/// milk; a coarse lotus of 1 mm came closest to exceeding it. Interpolated logarithmically.
pub(crate) fn link_error(tolerance: f64) -> f64 {
    const MET: [(f64, f64); 5] = [(1e-5, 1.5e-6), (1e-4, 8e-5), (1e-3, 2.6e-3), (1e-2, 0.09), (0.1, 1.2)];
    let row = MET.windows(2).find(|pair| tolerance <= pair[1].0).unwrap_or(&MET[3..]);
    let [(low, at_low), (high, at_high)] = [row[0], row[1]];
    let part = ((tolerance / low).ln() / (high / low).ln()).clamp(0.0, 1.0);
    at_low * (at_high / at_low).powf(part)
}

/// Groups an object's channels: those whose lights, refraction and entry texture differ by a constant factor are
/// transported together. Channels without light, entry or scattering are in no group.
pub(crate) fn group(params: &mut ObjectParams, texels: &[[f32; 3]], lights: &[Light]) -> Vec<Group> {
    let texture = brightest_entry(params, texels);
    let colors: Vec<[f64; 3]> = lights.iter().map(Light::color).collect();
    let most = [0, 1, 2].map(|c| colors.iter().map(|color| color[c]).fold(0.0, f64::max));
    let mut open: Vec<usize> =
        (0..3).filter(|&c| most[c] > 0.0 && texture[c] > 0.0 && params.strength[c] > 0.0).collect();
    open.sort_by(|&a, &b| most[b].total_cmp(&most[a]).then(a.cmp(&b)));
    params.tint = [1.0; 3];
    let mut groups = Vec::new();
    while let Some(&lead) = open.first() {
        let alike = |c: usize| {
            let ratio = most[c] / most[lead];
            let scaled = |light: &Light| light.proportional(c, lead, ratio, 1e-6 * most[c]);
            let eta = params.eta;
            let textured = || keeps_ratio(params, texels, texture, c, lead);
            eta[c] == eta[lead] && lights.iter().all(scaled) && (c == lead || textured())
        };
        let members: Vec<usize> = open.iter().copied().filter(|&c| alike(c)).collect();
        for &c in &members {
            params.tint[c] = (most[c] * texture[c] / (most[lead] * texture[lead])) as f32;
        }
        groups.push(Group { channels: members.iter().map(|c| 1 << c).sum(), lead: lead as u32 });
        open.retain(|c| !members.contains(c));
    }
    groups
}
