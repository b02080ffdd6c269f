//! Which dispatches of a frame have to wait for earlier ones, and for which.

use std::collections::BTreeMap;

use ash::vk;
use ash::vk::Handle as _;

use super::choices::Barriers;
use super::list::{Groups, Listed};

/// What a dispatch waits for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Wait {
    /// The last dispatch that has to be done, by its index.
    pub(super) after: usize,
    /// The buffers in question.
    pub(super) buffers: Vec<vk::Buffer>,
}

/// The last dispatches that read and wrote a buffer, as far as later ones still have to wait for them.
#[derive(Clone, Copy, Default)]
struct Pending {
    read: Option<usize>,
    written: Option<usize>,
}

/// What each dispatch waits for, if it reads what an earlier one wrote, or writes what an earlier one read or wrote.
pub(super) fn waits(list: &[&Listed], barriers: Barriers) -> Vec<Option<Wait>> {
    let mut pending: BTreeMap<u64, Pending> = BTreeMap::new();
    let mut found = Vec::with_capacity(list.len());
    for (index, dispatch) in list.iter().enumerate() {
        let mut wait: Option<Wait> = None;
        for (buffer, _, writes) in uses(dispatch) {
            let Some(known) = pending.get(&buffer.as_raw()) else { continue };
            if let Some(after) = known.written.max(known.read.filter(|_| writes)) {
                let wait = wait.get_or_insert_default();
                wait.after = wait.after.max(after);
                wait.buffers.push(buffer);
            }
        }
        if barriers == Barriers::Every && index > 0 {
            wait.get_or_insert_default().after = index - 1;
        }
        // What has been waited for.
        match (&wait, barriers) {
            (None, _) => {}
            (Some(wait), Barriers::Buffer) => {
                for buffer in &wait.buffers {
                    pending.remove(&buffer.as_raw());
                }
            }
            (Some(wait), Barriers::Events) => pending.values_mut().for_each(|entry| {
                entry.read = entry.read.filter(|at| *at > wait.after);
                entry.written = entry.written.filter(|at| *at > wait.after);
            }),
            (Some(_), Barriers::Elided | Barriers::Every | Barriers::Synchronization2) => pending.clear(),
        }
        for (buffer, reads, writes) in uses(dispatch) {
            let entry = pending.entry(buffer.as_raw()).or_default();
            entry.read = if reads { Some(index) } else { entry.read };
            entry.written = if writes { Some(index) } else { entry.written };
        }
        found.push(wait);
    }
    found
}

/// The buffers of a dispatch, and whether it reads and writes them.
pub(super) fn uses(dispatch: &Listed) -> impl Iterator<Item = (vk::Buffer, bool, bool)> + '_ {
    let bound = dispatch.kernel.accesses.iter().zip(&dispatch.ranges);
    let counted = match dispatch.groups {
        Groups::Counted { range, .. } => Some((range.buffer, true, false)),
        Groups::Direct(_) => None,
    };
    bound.map(|(access, range)| (range.buffer, access.reads, access.writes)).chain(counted)
}
