//! Differences between the needs of two scenes' frames.

use std::collections::BTreeMap;

use super::WHOLE;
use crate::cli::{size, table};
use milkglass::error::Result;
use milkglass::internals::session::run::Session;

/// Names of the sections, in order.
const SECTIONS: [&str; 4] = ["stage", "kernel", "buffer", "left out"];

/// A table of the differences; a dash marks what one of the two lacks.
pub(super) fn text(one: &Session, other: &Session) -> Result<String> {
    let [first, second] = [listed(one)?, listed(other)?];
    let mut rows = Vec::new();
    let mut keys: Vec<_> = first.keys().chain(second.keys()).collect();
    keys.sort();
    keys.dedup();
    for key in keys {
        let value = |list: &BTreeMap<(usize, String), String>| list.get(key).cloned().unwrap_or_else(|| "-".into());
        if first.get(key) != second.get(key) {
            rows.push(vec![SECTIONS[key.0].to_string(), key.1.clone(), value(&first), value(&second)]);
        }
    }
    let [left, right] = [one.scene().name.clone(), other.scene().name.clone()];
    if rows.is_empty() {
        return Ok(format!("{left} and {right} need the same\n"));
    }
    Ok(table(["", "what", &format!("{left}, as asked for"), &right], rows))
}

/// Everything that a plan lists: values by section and key.
fn listed(session: &Session) -> Result<BTreeMap<(usize, String), String>> {
    let mut list = BTreeMap::new();
    for need in session.needs(WHOLE)? {
        let [read, written] = need.bytes.map(size);
        let value = format!("{} dispatches, {read} to read, {written} to write", need.dispatches);
        list.insert((0, need.stage.to_string()), value);
        for kernel in need.kernels {
            let value = format!("{} x {}", kernel.dispatches, kernel.specialized()?);
            let value = value.trim_end_matches([' ', 'x']).to_string();
            let values: &mut String = list.entry((1, kernel.name.clone())).or_default();
            *values = if values.is_empty() { value } else { format!("{values}; {value}") };
        }
    }
    for (slot, bytes) in session.buffers() {
        list.insert((2, slot.spec().name.to_string()), size(bytes));
    }
    for (what, why) in &session.plan().left_out {
        list.insert((3, (*what).to_string()), why.clone());
    }
    Ok(list)
}
