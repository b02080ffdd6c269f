//! The order of a kernel's blocks: each before those that it branches to, except back to the head of its loop, and the
//! block where branches meet after all that lies between. Of the blocks in which invocations are, the first one of
//! this order runs next, so that those that took different ways are together again where the ways meet.

use super::code::{Block, Decoded};

/// The blocks in that order, without those that nothing reaches; their edges name the new places.
pub(super) fn ordered(mut blocks: Vec<Block>) -> Decoded<Vec<Block>> {
    let count = blocks.len();
    let within = |block: &mut Block| {
        block.end.edges_mut().all(|edge| edge.to < count) && block.merges.iter().all(|to| *to < count)
    };
    if count == 0 || !blocks.iter_mut().all(within) {
        return Err("a block goes on where there is none".into());
    }
    let order = order(&blocks);
    let mut place = vec![usize::MAX; blocks.len()];
    for (new, old) in order.iter().enumerate() {
        place[*old] = new;
    }
    let mut blocks: Vec<Option<Block>> = blocks.into_iter().map(Some).collect();
    let mut sorted: Vec<Block> = order.iter().filter_map(|old| blocks[*old].take()).collect();
    for block in &mut sorted {
        block.end.edges_mut().for_each(|edge| edge.to = place[edge.to]);
        block.merges.clear();
    }
    Ok(sorted)
}

/// Depth first, the places where ways meet before the ways, and then backwards.
fn order(blocks: &[Block]) -> Vec<usize> {
    let next = |block: &Block| -> Vec<usize> {
        let mut end = block.end.clone();
        block.merges.iter().copied().chain(end.edges_mut().map(|edge| edge.to)).collect()
    };
    let mut seen = vec![false; blocks.len()];
    let mut done = Vec::with_capacity(blocks.len());
    // A stack of its own: kernels may have thousands of blocks, one behind the other.
    let mut stack = vec![(0, next(&blocks[0]), 0)];
    seen[0] = true;
    while let Some((block, after, at)) = stack.last_mut() {
        match after.get(*at) {
            Some(&to) => {
                *at += 1;
                if !std::mem::replace(&mut seen[to], true) {
                    stack.push((to, next(&blocks[to]), 0));
                }
            }
            None => {
                done.push(*block);
                stack.pop();
            }
        }
    }
    done.reverse();
    done
}
