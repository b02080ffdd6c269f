//! The wide nodes that rays walk on a device: those of the trees of all objects, and above them, if there are several,
//! as many as hold the roots.

use std::cmp::Reverse;

use crate::hierarchy::Tree;
use crate::hierarchy::wide::widen;
use crate::layout::{NONE, WIDE};
use crate::state::State;

/// Writes the wide nodes.
pub fn wide(state: &mut State, trees: &[Tree]) {
    // By falling size, as children are in a tree. One tree needs nothing above its root.
    let mut order: Vec<usize> = (0..trees.len()).filter(|&object| trees[object].nodes() > 0).collect();
    order.sort_by_key(|&object| Reverse(trees[object].nodes()));
    let above = if order.len() > 1 { order.len().div_ceil(WIDE) } else { 0 };

    let link = |node: usize, wide: Option<usize>| [node as u32, wide.map_or(0, |wide| (wide * WIDE) as u32)];
    let mut links = vec![[NONE, 0]; above * WIDE];
    for (place, &object) in order.iter().enumerate() {
        let (first, nodes) = (links.len() / WIDE, state.objects[object].first.nodes);
        if above > 0 {
            links[place] = link(nodes, Some(first));
        }
        for children in widen(&trees[object], WIDE) {
            let used = children
                .iter()
                .map(|child| link(nodes + child.node as usize, child.wide.map(|wide| first + wide as usize)));
            links.extend(used.chain(std::iter::repeat_n([NONE, 0], WIDE - children.len())));
        }
    }
    state.data.wide_links = links;
    state.data.object_params[0].wide_tops = above.max(order.len().min(1)) as u32;
}
