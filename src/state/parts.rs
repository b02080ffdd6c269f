//! The parts of a buffer, one of which a dispatch binds: that of an object, a group of channels, a chunk of links or
//! a batch of blocks.

use super::{Object, Scope, State};
use crate::layout::{BufferId, Partition, Runs, SMALL_SYSTEM};

impl State {
    /// The batches of all objects and groups of channels, each with its blocks.
    pub fn batches(&self) -> impl Iterator<Item = (Scope, &std::ops::Range<u32>)> + '_ {
        self.objects.iter().enumerate().flat_map(|(object, part)| {
            let batches = part.schedule.batches.iter().enumerate();
            let of_group =
                move |group| batches.clone().map(move |(chunk, batch)| (Scope { object, chunk, group }, batch));
            (0..part.groups.len()).flat_map(of_group)
        })
    }

    /// The list ranges of all blocks: of every batch where lists are kept, else only of the last one. The gaps
    /// between the parts of batches are left out, because on a device they may hold anything.
    pub fn runs(&self) -> impl Iterator<Item = &Runs> + '_ {
        let there = if self.keep { 0 } else { self.batches().count().saturating_sub(1) };
        let of_batch = |(at, batch): (Scope, &std::ops::Range<u32>)| {
            let first = self.part(BufferId::runs, at).0;
            self.data.runs.get(first..first + batch.len()).unwrap_or_default()
        };
        self.batches().skip(there).flat_map(of_batch)
    }

    /// Number of chunks of all translucent objects.
    pub fn chunk_count(&self) -> usize {
        self.sum(chunks)
    }

    /// Number of batches over all objects and groups of channels.
    pub fn batch_count(&self) -> usize {
        self.sum(batches)
    }

    /// Number of parts of a buffer of chunk lists: one per chunk where lists are kept, else one that all share.
    pub fn chunk_parts(&self) -> usize {
        if self.keep { self.chunk_count() } else { 1 }
    }

    /// Number of parts of a buffer of batch lists: one per batch and group where lists are kept, else one that all
    /// share.
    pub fn batch_parts(&self) -> usize {
        if self.keep { self.batch_count() } else { 1 }
    }

    /// Number of blocks of the largest batch.
    pub fn largest_batch(&self) -> usize {
        let batches = self.objects.iter().flat_map(|object| &object.schedule.batches);
        batches.map(|batch| batch.len()).max().unwrap_or(0)
    }

    /// The part of a buffer that a dispatch of this scope binds: first element and number of elements.
    pub fn part(&self, id: BufferId, at: Scope) -> (usize, usize) {
        let (cut, all) = (id.spec().partition, self.data.bytes(id).len() / id.spec().stride);
        let Some(object) = self.objects.get(at.object).filter(|_| all > 0) else { return (0, all) };
        let before = |count: fn(&Object) -> usize| self.objects[..at.object].iter().map(count).sum::<usize>();
        let (part, parts) = match cut {
            Partition::Whole => return (0, all),
            Partition::Object => return (at.object, 1),
            Partition::Small => return (at.object * SMALL_SYSTEM, SMALL_SYSTEM),
            Partition::Vectors => return (before(Object::of_vectors), object.vectors * object.count.faces),
            Partition::Group => {
                let first = before(|object| object.groups.len() * object.of_group());
                return (first + at.group * object.of_group(), object.of_group());
            }
            Partition::Chunk => (before(chunks) + at.chunk, self.sum(chunks)),
            Partition::Batch => {
                (before(batches) + at.group * object.schedule.batches.len() + at.chunk, self.sum(batches))
            }
            // A buffer of which later objects have no elements ends before their range.
            _ => {
                return Some(object.run(cut, self.data.object_params[0].shadow_words as usize))
                    .filter(|run| run.0 + run.1 <= all)
                    .unwrap_or_default();
            }
        };
        let length = all / parts.max(1);
        if self.keep { (part * length, length) } else { (0, all) }
    }

    /// All parts of one object in a buffer: first element and number of elements.
    pub(super) fn parts(&self, id: BufferId, number: usize) -> (usize, usize) {
        let (object, at) = (&self.objects[number], Scope { object: number, ..Scope::default() });
        let (first, count) = self.part(id, at);
        match id.spec().partition {
            Partition::Group if count > 0 => (first, count * object.groups.len()),
            Partition::Chunk if self.keep => (first, count * chunks(object)),
            Partition::Batch if self.keep => (first, count * batches(object)),
            _ => (first, count),
        }
    }
}

/// Number of chunks that are linked; none if the object is opaque.
fn chunks(object: &Object) -> usize {
    if object.opaque { 0 } else { object.schedule.chunks.len() }
}

fn batches(object: &Object) -> usize {
    object.groups.len() * object.schedule.batches.len()
}
