//! Patches: parts of a surface over which a walk's noise, and errors against it, are taken: nodes of the object's tree
//! of balanced area.

use std::ops::Range;

use crate::state::State;

/// Patches of an object; fewer where it has fewer triangles.
pub const PATCHES: usize = 200;

/// The faces of each patch, counted from the object's first one. The largest node is divided until there are
/// [`PATCHES`], or only triangles are left.
#[must_use]
pub fn patches(state: &State, object: usize) -> Vec<Range<usize>> {
    let (data, object) = (&state.data, &state.objects[object]);
    let topology = &data.topology[object.first.nodes..][..object.count.nodes];
    let area = |node: usize| data.clusters[object.first.nodes + node].area;
    let mut parts = vec![0usize];
    while parts.len() < PATCHES {
        let wide = parts.iter().enumerate().filter(|(_, node)| topology[**node].skip as usize > **node + 1);
        let Some((at, &node)) = wide.max_by(|a, b| area(*a.1).total_cmp(&area(*b.1))) else { break };
        parts[at] = node + 1;
        parts.push(topology[node + 1].skip as usize);
    }
    parts.sort_unstable();
    // Faces are numbered in the order of the leaves.
    let first = |node: usize| topology[node..].iter().find(|t| t.face != u32::MAX).map_or(0, |t| t.face as usize);
    let faces = |&node: &usize| {
        let first = first(node);
        first..first + (topology[node].skip as usize - node).div_ceil(2)
    };
    parts.iter().map(faces).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::plan::Options;
    use crate::scene::Scene;
    use crate::session::run::Session;

    #[test]
    fn patches_cover_every_face_once_and_are_alike() {
        for (detail, count) in [(0, 20), (3, PATCHES)] {
            let sets = [format!("object.0.detail={detail}")];
            let scene = Scene::load_with("sphere", &sets).unwrap();
            let mut session = Session::new(&scene, None, Options::default()).unwrap();
            session.frame(crate::pipeline::plan::Change::EVERYTHING).unwrap();
            let found = patches(session.state(), 0);
            assert_eq!(found.len(), count);
            assert!(found.iter().all(|faces| !faces.is_empty()));
            assert!(found.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert_eq!((found[0].start, found[count - 1].end), (0, session.state().objects[0].count.faces));
            let [least, most] = [Iterator::min, Iterator::max].map(|of| of(found.iter().map(Range::len)).unwrap());
            assert!(most <= 4 * least, "{least} to {most}");
        }
    }
}
