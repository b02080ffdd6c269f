//! The borders of clusters, for scheme `links`: what near clusters are integrated over.

use crate::hierarchy::{Tree, border};
use crate::state::State;

/// Edges of a cluster's border at most; a cluster with a longer one takes one sample. Each edge costs a kernel two
/// steps of its loops, of which lavapipe has 65,535.
const MOST_BORDER: usize = 4_096;

/// The borders of the clusters of every translucent object.
pub fn borders(state: &mut State, trees: &[Tree]) {
    let data = &mut state.data;
    data.borders = vec![[0; 2]; data.topology.len()];
    for ((object, tree), params) in state.objects.iter().zip(trees).zip(&mut data.object_params) {
        if object.opaque {
            continue;
        }
        let first = data.border_edges.len() as u32;
        let triangles = &data.triangles[object.first.faces..][..object.count.faces];
        let found = border::borders(tree, triangles, MOST_BORDER);
        for (place, [start, count]) in data.borders[object.first.nodes..].iter_mut().zip(found.runs) {
            *place = [if count > 0 { first + start } else { 0 }, count];
        }
        data.border_edges.extend(found.edges);
        params.projected = 1;
    }
}
