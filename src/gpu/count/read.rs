//! What a module of SPIR-V declares, and what its instructions do.

use std::collections::BTreeMap;

use super::{Block, STORAGE_BUFFER};

/// What is known of a module's ids.
#[derive(Default)]
pub(super) struct Ids {
    /// Components and bytes of each type; of a pointer none.
    types: BTreeMap<u32, [u32; 2]>,
    constants: BTreeMap<u32, u32>,
    /// The type of each value.
    values: BTreeMap<u32, u32>,
    bindings: BTreeMap<u32, u32>,
    /// The binding behind each pointer into a buffer.
    pointers: BTreeMap<u32, u32>,
    /// The GLSL instructions.
    pub(super) glsl: u32,
    pub(super) entry: u32,
    pub(super) uint: Option<u32>,
    pub(super) boolean: Option<u32>,
}

impl Ids {
    fn components(&self, ty: u32) -> u32 {
        self.types.get(&ty).map_or(1, |size| size[0])
    }

    fn bytes_of(&self, value: u32) -> u32 {
        self.values.get(&value).and_then(|ty| self.types.get(ty)).map_or(4, |size| size[1])
    }

    /// Learns from an instruction what it declares.
    pub(super) fn learn(&mut self, op: u32, of: &[u32]) {
        let size = |ids: &Self, ty: u32| ids.types.get(&ty).copied().unwrap_or([1, 4]);
        match (op, of) {
            (11, [id, ..]) => self.glsl = *id,
            (15, [_, id, ..]) => self.entry = *id,
            (71, [id, 33, number]) => {
                self.bindings.insert(*id, *number);
            }
            (20, [id]) => {
                self.boolean = Some(*id);
                self.types.insert(*id, [1, 4]);
            }
            (21 | 22, [id, bits, ..]) => {
                if of == [*id, 32, 0] {
                    self.uint = Some(*id);
                }
                self.types.insert(*id, [1, bits / 8]);
            }
            (23 | 24, [id, part, count]) => {
                let [components, bytes] = size(self, *part);
                self.types.insert(*id, [components * count, bytes * count]);
            }
            (28, [id, part, length]) => {
                let count = self.constants.get(length).copied().unwrap_or(1);
                self.types.insert(*id, [1, size(self, *part)[1] * count]);
            }
            (30, [id, members @ ..]) => {
                let bytes = members.iter().map(|member| size(self, *member)[1]).sum();
                self.types.insert(*id, [1, bytes]);
            }
            (19 | 29 | 32 | 33, [id, ..]) => {
                self.types.insert(*id, [1, 0]);
            }
            (43, [_, id, value]) => {
                self.constants.insert(*id, *value);
            }
            (59, [_, id, STORAGE_BUFFER, ..]) => {
                if let Some(&binding) = self.bindings.get(id) {
                    self.pointers.insert(*id, binding);
                }
            }
            (65 | 66, [_, id, base, ..]) => {
                if let Some(&binding) = self.pointers.get(base) {
                    self.pointers.insert(*id, binding);
                }
            }
            _ => {}
        }
        if let [ty, value, ..] = of
            && op > 33
            && self.types.contains_key(ty)
        {
            self.values.insert(*value, *ty);
        }
    }

    /// Adds what an instruction does to its block.
    pub(super) fn add(&self, block: &mut Block, op: u32, of: &[u32]) {
        let mut moves = |pointer: u32, read: u32, written: u32| {
            if let Some(&binding) = self.pointers.get(&pointer) {
                let sum = block.moved.entry(binding).or_default();
                (sum[0], sum[1]) = (sum[0] + read, sum[1] + written);
            }
        };
        match (op, of) {
            (61, [_, id, pointer, ..]) => return moves(*pointer, self.bytes_of(*id), 0),
            (62, [pointer, value, ..]) => return moves(*pointer, 0, self.bytes_of(*value)),
            (227, [_, _, pointer, ..]) => return moves(*pointer, 4, 0),
            (228, [pointer, ..]) => return moves(*pointer, 0, 4),
            (229..=242, [_, _, pointer, ..]) => return moves(*pointer, 4, 4),
            _ => {}
        }
        let [ty, _, rest @ ..] = of else { return };
        let n = self.components(*ty);
        let operand =
            |k: usize| rest.get(k).and_then(|value| self.values.get(value)).map_or(n, |ty| self.components(*ty));
        match op {
            129 | 131 | 133 | 142 | 143 | 147 => block.flops += n,
            136 | 140 | 141 => block.roots += n,
            144 => block.flops += 2 * operand(1) - n,
            145 => block.flops += 2 * operand(0) - n,
            148 => block.flops += 2 * operand(0) - 1,
            12 if rest.first() == Some(&self.glsl) => {
                let vector = operand(2);
                let [flops, roots, exps] = match rest.get(1) {
                    Some(13..=25 | 27..=30) => [0, 0, n],
                    Some(26) => [0, 0, 2 * n],
                    Some(31 | 32) => [0, n, 0],
                    Some(46) => [3 * n, 0, 0],
                    Some(49) => [6 * n, n, 0],
                    Some(50) => [2 * n, 0, 0],
                    Some(66) => [2 * vector - 1, 1, 0],
                    Some(67) => [3 * vector - 1, 1, 0],
                    Some(68) => [9, 0, 0],
                    Some(69) => [3 * vector - 1, 1, 0],
                    Some(71) => [4 * vector, 0, 0],
                    _ => [0; 3],
                };
                (block.flops, block.roots, block.exps) = (block.flops + flops, block.roots + roots, block.exps + exps);
            }
            _ => {}
        }
    }
}
