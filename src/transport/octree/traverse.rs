//! Lists the sources that a packet of receivers sums: a cell's solid angle and box are tested at the nearest point of
//! the box around the packet.

use fearless_simd::{Simd, f32x8, prelude::*};

use super::{Children, Octree};

/// A walk's result and scratch memory, reused for the next packet.
#[derive(Debug, Default)]
pub struct Walk {
    /// The sources to sum.
    pub list: Vec<u32>,
    open: Vec<Children>,
}

/// Takes the lowest set bit out of a mask.
#[inline(always)]
fn take(mask: &mut u64) -> usize {
    let bit = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    bit
}

impl Octree {
    /// Lists the sources for receivers in the box `low`, `high`. The tree must have a node.
    #[inline(always)]
    pub(super) fn walk<S: Simd>(&self, simd: S, threshold: f32, [low, high]: [[f32; 3]; 2], walk: &mut Walk) {
        let Walk { list, open } = walk;
        list.clear();
        open.push(Children { first: 0, count: 1 });
        while let Some(Children { first, count }) = open.pop() {
            let first = first as usize;
            let siblings = first..first + 8;
            let mut d2 = f32x8::splat(simd, 0.0);
            for k in 0..3 {
                let place = f32x8::from_slice(simd, &self.places[k][siblings.clone()]);
                let outside = (low[k] - place).max(place - high[k]).max(0.0);
                d2 = outside.mul_add(outside, d2);
            }
            let all = (1 << count) - 1;
            let area = f32x8::from_slice(simd, &self.areas[siblings.clone()]);
            let mut near = (d2 * threshold).simd_lt(area).to_bitmask() & all;

            // Boxes matter only for the few cells that look small from close by.
            let reach = f32x8::from_slice(simd, &self.reaches[siblings]);
            let mut close = d2.simd_le(reach).to_bitmask() & all & !near;
            while close != 0 {
                let child = take(&mut close);
                let [from, to] = self.boxes[first + child];
                let single = self.reaches[first + child] == 0.0;
                if !single && (0..3).all(|k| low[k] <= to[k] && high[k] >= from[k]) {
                    near |= 1 << child;
                }
            }

            let mut far = all & !near;
            while far != 0 {
                list.push((first + take(&mut far)) as u32);
            }
            while near != 0 {
                let inner = self.children[first + take(&mut near)];
                if (inner.first as usize) < self.children.len() {
                    open.push(inner);
                } else {
                    list.extend(inner.first..inner.first + inner.count);
                }
            }
        }
    }
}
