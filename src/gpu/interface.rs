//! SPIR-V that was read from a file: what it binds and takes, and its text.

use rspirv::binary::Disassemble as _;

use super::reflect::reflect;
use super::spirv_module::{MAGIC, whole};
use crate::error::{Error, Result};

/// What a kernel binds and takes.
pub(crate) struct Interface {
    /// The numbers of its bindings.
    pub(crate) bindings: Vec<u32>,
    /// Those whose number of elements it asks for.
    pub(crate) lengths: Vec<u32>,
    /// Bytes of push constants.
    pub(crate) push_bytes: u32,
    /// How many specialization constants it has.
    pub(crate) constants: usize,
}

/// What a module binds and takes, or why it can't be used.
pub(crate) fn interface(name: &str, words: &[u32]) -> Result<Interface> {
    let doing = || format!("reading kernel {name}");
    if words.first() != Some(&MAGIC) || !whole(words) {
        return Err(Error::device(doing(), "it is no SPIR-V"));
    }
    // What reads structure finds out whether instructions are whole.
    rspirv::dr::load_words(words).map_err(|error| Error::device(doing(), error))?;
    let found = reflect(name, words)?;
    Ok(Interface {
        bindings: found.accesses.iter().map(|access| access.binding).collect(),
        lengths: found.accesses.iter().filter(|access| access.asks_length).map(|access| access.binding).collect(),
        push_bytes: found.push_bytes,
        constants: found.set_by_program().count(),
    })
}

/// The text of a module; says why where there is none.
pub(crate) fn disassembled(words: &[u32]) -> String {
    match rspirv::dr::load_words(words) {
        Ok(module) => format!("{}\n", module.disassemble().trim_end()),
        Err(error) => format!("; {error}\n"),
    }
}
