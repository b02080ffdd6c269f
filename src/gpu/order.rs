//! Which dispatches of a frame have to wait for earlier ones, and for which.

use std::collections::BTreeMap;

use ash::vk;

use super::choices::Barriers;
use super::list::{Groups, Listed};

/// What a dispatch waits for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Wait<B = vk::Buffer> {
    /// The last dispatch that has to be done, by its index.
    pub(crate) after: usize,
    /// The buffers in question.
    pub(crate) buffers: Vec<B>,
}

/// The last dispatches that read and wrote a buffer, as far as later ones still have to wait for them.
#[derive(Clone, Copy, Default)]
struct Pending {
    read: Option<usize>,
    written: Option<usize>,
}

/// What each dispatch waits for, if it reads what an earlier one wrote, or writes what an earlier one read or wrote. Of
/// each dispatch the list has its buffers, and whether it reads and writes them.
pub(crate) fn waits<B: Copy + Ord, U: IntoIterator<Item = (B, bool, bool)> + Clone>(
    list: impl IntoIterator<Item = U>,
    barriers: Barriers,
) -> Vec<Option<Wait<B>>> {
    let mut pending: BTreeMap<B, Pending> = BTreeMap::new();
    let mut found = Vec::new();
    for (index, uses) in list.into_iter().enumerate() {
        let mut wait: Option<Wait<B>> = None;
        for (buffer, _, writes) in uses.clone() {
            let Some(known) = pending.get(&buffer) else { continue };
            if let Some(after) = known.written.max(known.read.filter(|_| writes)) {
                let wait = wait.get_or_insert(Wait { after: 0, buffers: Vec::new() });
                wait.after = wait.after.max(after);
                wait.buffers.push(buffer);
            }
        }
        if barriers == Barriers::Every && index > 0 {
            wait.get_or_insert(Wait { after: 0, buffers: Vec::new() }).after = index - 1;
        }
        // What has been waited for.
        match (&wait, barriers) {
            (None, _) => {}
            (Some(wait), Barriers::Buffer) => {
                for buffer in &wait.buffers {
                    pending.remove(buffer);
                }
            }
            (Some(wait), Barriers::Events) => pending.values_mut().for_each(|entry| {
                entry.read = entry.read.filter(|at| *at > wait.after);
                entry.written = entry.written.filter(|at| *at > wait.after);
            }),
            (Some(_), Barriers::Elided | Barriers::Every | Barriers::Synchronization2) => pending.clear(),
        }
        for (buffer, reads, writes) in uses {
            let entry = pending.entry(buffer).or_default();
            entry.read = if reads { Some(index) } else { entry.read };
            entry.written = if writes { Some(index) } else { entry.written };
        }
        found.push(wait);
    }
    found
}

/// The buffers of a dispatch that have any bytes, and whether it reads and writes them.
pub(super) fn uses(dispatch: &Listed) -> impl Iterator<Item = (vk::Buffer, bool, bool)> + Clone + '_ {
    let bound = dispatch.kernel.accesses.iter().zip(&dispatch.ranges);
    let counted = match dispatch.groups {
        Groups::Counted { range, .. } => Some((range.buffer, true, false)),
        Groups::Direct(_) => None,
    };
    let bound = bound.filter(|(_, range)| range.size > 0);
    bound.map(|(access, range)| (range.buffer, access.reads, access.writes)).chain(counted)
}
