//! A copy of a SPIR-V module that notes how far into each buffer it reaches.

use std::collections::BTreeMap;

use spirq::spirv::Op;

use super::read::Module;
use super::write::Counters;
use crate::gpu::reflect::reflect;
use crate::gpu::spirv_module::Edited;

/// A kernel that notes how far it reaches.
pub(crate) struct Touching {
    /// Its SPIR-V.
    pub(crate) words: Vec<u32>,
    /// Of each word that it notes, in order: the binding, and the bytes of an element. The word becomes the number of
    /// elements up to the last one that is named.
    pub(crate) notes: Vec<(u32, usize)>,
}

/// The kernel with notes at [`super::BINDING`]; none where the SPIR-V is not of the kind that the build makes.
pub(crate) fn touching(name: &str, words: &[u32]) -> Option<Touching> {
    let strides: BTreeMap<u32, usize> = reflect(name, words).ok()?.strides.clone();
    let notes: Vec<(u32, usize)> = strides.into_iter().collect();
    let module = Module::of(words);
    let mut out = Edited::begin(words)?;
    let counters = Counters::declare(&mut out, &module.declared, notes.len() as u32, false);
    let words = out.finish(words, |out, instruction| {
        // The variable, its only member, the element.
        if let (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, _, base, _, index, ..]) =
            (instruction.op, instruction.operands)
            && let Some(note) = module.binding(*base).and_then(|b| notes.iter().position(|(noted, _)| *noted == b))
        {
            counters.note(out, note as u32, *index, module.is_unsigned(*index));
        }
        counters.keep(out, instruction);
        Some(())
    })?;
    Some(Touching { words, notes })
}
