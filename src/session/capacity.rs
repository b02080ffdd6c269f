//! Capacities of the lists of links: chunks and batches that fit the device's bindings, and growth after an overflow.

use crate::error::{Error, KeepLimit, Result};
use crate::gpu::Limits;
use crate::layout::{ListCounters, NOTED_EXTRA};
use crate::prepare::scene::{Prepared, schedule};
use crate::state::{Object, Scheme, State};
use crate::transport::blocks::gather::NEAR_PART;

/// Initial faces of a chunk; fewer once a chunk's lists do not fit a binding.
const CHUNK_FACES: usize = 1 << 14;
/// Largest list on the CPU, bytes: the smallest binding limit among devices.
const CPU_BINDING: u64 = 1 << 27;
/// Most bytes kept between frames on the CPU.
const CPU_ALLOCATION: u64 = 1 << 32;
/// Largest list on any back end, bytes.
const MOST_BINDING: u64 = 1 << 29;
/// Most blocks in a batch: with 65,000 entries each, their sum still fits 32 bits.
const MOST_BLOCKS: usize = 1 << 16;
/// Initial entries of a block's lists.
const ENTRIES: usize = 512;
/// Links per face, or entries per block, that nearly every scene exceeds.
const FEW: usize = 64;
/// Initial links per face.
const LINKS: usize = 640;

/// Initial capacities. Tests choose small ones to make lists overflow or chunks small.
#[derive(Clone, Copy, Debug)]
pub struct CapacityHints {
    /// Faces of a chunk.
    pub chunk_faces: usize,
    /// Links per face of a chunk.
    pub links: usize,
    /// Most blocks in a batch.
    pub batch_blocks: usize,
    /// Largest list, bytes; further limited by the device.
    pub binding: u64,
    /// Most bytes kept between frames; further limited by the device.
    pub kept: u64,
}

impl Default for CapacityHints {
    fn default() -> Self {
        Self {
            chunk_faces: CHUNK_FACES,
            links: LINKS,
            batch_blocks: MOST_BLOCKS,
            binding: MOST_BINDING,
            kept: u64::MAX,
        }
    }
}

/// The partition of the lists and their capacities, on one device.
#[derive(Clone)]
pub struct Lists {
    /// Initial capacities.
    initial: CapacityHints,
    /// Faces of a chunk.
    chunk_faces: usize,
    /// Largest list of a chunk, bytes.
    binding: u64,
    /// Blocks of a batch at most.
    batch_blocks: usize,
    /// Largest kept list over all chunks together, bytes.
    pub(crate) allocation: u64,
    /// What sets that limit.
    limited_by: KeepLimit,
}

/// How lists gain capacity after an overflow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// Lists are longer; chunks and batches stay as they are.
    Longer,
    /// Chunks or batches are smaller, so that each list has less to hold.
    SmallerParts,
}

impl Lists {
    /// The lists of a device, or of the CPU where there is none.
    pub fn new(hints: CapacityHints, device: Option<&Limits>) -> Self {
        // Kept lists leave half of the device's memory to everything else.
        let kept = |limits: &Limits| limits.allocation_bytes.min(limits.heap_bytes / 2);
        let (binding, allocation) =
            device.map_or((CPU_BINDING, CPU_ALLOCATION), |limits| (limits.binding_bytes, kept(limits)));
        Self {
            initial: CapacityHints { batch_blocks: hints.batch_blocks.clamp(1, MOST_BLOCKS), ..hints },
            chunk_faces: hints.chunk_faces,
            batch_blocks: hints.batch_blocks.clamp(1, MOST_BLOCKS),
            binding: hints.binding.min(binding).min(allocation),
            allocation: allocation.min(hints.kept),
            limited_by: if hints.kept < allocation { KeepLimit::MemoryOption } else { KeepLimit::Device },
        }
    }

    /// Partitions the tree into chunks and gives every list its initial capacity.
    pub fn cut(&self, prepared: &mut Prepared) {
        if prepared.state.method.scheme == Scheme::Blocks {
            schedule(prepared, usize::MAX / 4);
            self.batches(&mut prepared.state, ENTRIES * self.initial.links / LINKS);
            return;
        }
        schedule(prepared, self.chunk_faces);
        let faces = largest_chunk(prepared);
        let chunks = prepared.state.chunk_count().max(1);
        let kept = if prepared.state.keep { (self.allocation / 12) as usize / chunks } else { usize::MAX };
        let capacity = |per: usize, stride| ((faces * per).min(kept).min(self.most(stride)).max(64) / 64 * 64) as u32;
        set(prepared, [capacity(self.initial.links, 12), capacity(16, 4), capacity(4, 4), capacity(96, 4)]);
    }

    /// Partitions a new state in the same way; returns these lists.
    pub fn cut_new(self, prepared: &mut Prepared) -> Self {
        self.cut(prepared);
        self
    }

    /// The lists of another state on the same device: where its objects have the same counts and groups, the partition
    /// and the capacities that were found to serve the state `before`, otherwise the initial ones.
    pub fn again(&self, prepared: &mut Prepared, before: &State) -> Self {
        let CapacityHints { chunk_faces, batch_blocks, .. } = self.initial;
        let fresh = Self { chunk_faces, batch_blocks, ..self.clone() };
        let alike = |(a, b): (&Object, &Object)| a.count == b.count && a.groups == b.groups && a.opaque == b.opaque;
        let (new, old) = (&prepared.state.objects, &before.objects);
        let same = new.len() == old.len() && new.iter().zip(old).all(alike);
        if !same || prepared.state.keep != before.keep || prepared.state.method.scheme != before.method.scheme {
            return fresh.cut_new(prepared);
        }
        let lists = self.clone().cut_new(prepared);
        for (new, old) in prepared.state.data.object_params.iter_mut().zip(&before.data.object_params) {
            new.link_capacity = old.link_capacity;
            new.area_capacity = old.area_capacity;
            new.edge_capacity = old.edge_capacity;
            new.hand_capacity = old.hand_capacity;
            new.edit_capacity = old.edit_capacity;
            new.entry_capacity = old.entry_capacity;
            new.near_capacity = old.near_capacity;
        }
        lists
    }

    /// Fails if lists are to be kept although even short ones, which nearly every scene exceeds, are over the limit.
    pub fn too_much(&self, state: &State) -> Result<()> {
        let least_bytes = |object: &Object| match state.method.scheme {
            _ if object.opaque => 0,
            Scheme::Blocks => FEW * object.count.blocks * object.groups.len() * 4,
            Scheme::Links => FEW * object.count.faces * 12,
        };
        let bytes = state.sum(least_bytes) as u64;
        if state.keep && bytes > self.allocation { Err(too_many(bytes, self)) } else { Ok(()) }
    }

    /// Partitions the blocks into batches, with capacity for `per_block` entries per block.
    fn batches(&self, state: &mut State, per_block: usize) {
        state
            .data
            .object_params
            .iter_mut()
            .for_each(|params| params.near_capacity = params.near_capacity.max(NEAR_PART));
        // Kept lists stay within their limit.
        let all = state.sum(|object| object.groups.len() * object.count.blocks).max(1);
        let most = if state.keep { (self.allocation / 4) as usize / all } else { usize::MAX };
        let per_block = per_block.min(most);
        for object in &mut state.objects {
            let blocks = object.count.blocks;
            let batches = blocks.div_ceil(self.batch_blocks.min(self.most_entries() / per_block.max(1)).max(1)).max(1);
            let each = blocks.div_ceil(batches);
            let batch = |k: usize| (k * each).min(blocks) as u32..((k + 1) * each).min(blocks) as u32;
            object.schedule.batches = (0..batches).map(batch).filter(|batch| !batch.is_empty()).collect();
        }
        let capacity = ((state.largest_batch() * per_block).max(64) / 64 * 64).min(self.most_entries()) as u32;
        state.data.object_params.iter_mut().for_each(|params| params.entry_capacity = capacity);
    }

    /// Most elements of `stride` bytes in one list, a multiple of 64.
    pub(crate) fn most(&self, stride: u64) -> usize {
        (self.binding.min(u64::from(u32::MAX)) / stride / 64 * 64) as usize
    }

    /// Most entries of a batch, so that what `link` notes of them fits a binding, too: two words more for each
    /// `NOTED_LEAST` entries, and some for each block.
    fn most_entries(&self) -> usize {
        let most = self.most(4);
        let blocks = (NOTED_EXTRA * self.batch_blocks.min(MOST_BLOCKS)).min(most / 128);
        (most - most / 128 - blocks) / 64 * 64
    }

    /// After an overflow: longer lists, or smaller chunks where a list is as long as a binding allows.
    pub fn grow(&mut self, prepared: &mut Prepared) -> Result<Growth> {
        if prepared.state.method.scheme == Scheme::Blocks {
            return self.grow_batches(&mut prepared.state);
        }
        let need = need(&prepared.state);
        let params = prepared.state.data.object_params[0];
        let mut lists = [
            ("links", need.required_links, params.link_capacity, 12),
            ("area_links", need.required_areas, params.area_capacity, 4),
            ("edge_links", need.required_edges, params.edge_capacity, 4),
            ("handed", need.required_hands, params.hand_capacity, 4),
        ];
        // Emitters that could not be handed down hide those below them from the count, so the list at least doubles.
        if need.required_hands > params.hand_capacity {
            lists[3].1 = need.required_hands.max(params.hand_capacity.saturating_mul(2));
        }
        let mut capacities = lists.map(|(_, _, capacity, _)| capacity);
        for (capacity, (name, need, had, stride)) in capacities.iter_mut().zip(lists) {
            let (need, most) = (need as usize, self.most(stride));
            if need > most {
                // As many faces as fit at this density, less a quarter.
                let faces = largest_chunk(prepared).min(self.chunk_faces);
                self.chunk_faces = (faces as f64 * most as f64 / need as f64 * 0.75) as usize;
                if self.chunk_faces < 16 {
                    let what =
                        format!("it needs {need} entries for {faces} faces, a binding of the device takes {most}");
                    return Err(Error::device(format!("making room for buffer {name}"), what));
                }
                self.cut(prepared);
                return Ok(Growth::SmallerParts);
            }
            if need > had as usize {
                // Updated links are moved to spare capacity, as far as the kept lists fit one allocation.
                let kept = self.allocation as usize / 12 / prepared.state.chunk_count().max(1) / 64 * 64;
                let revised = name == "links" && prepared.state.method.incremental;
                let spare = if revised { (need / 4).min(kept.saturating_sub(need)) / 64 * 64 } else { need / 32 };
                *capacity = (need + spare).next_multiple_of(64).min(most) as u32;
            }
        }
        set(prepared, capacities);

        // Kept lists have to fit one allocation.
        let bytes = 12 * u64::from(capacities[0]) * prepared.state.chunk_count() as u64;
        if prepared.state.keep && bytes > self.allocation {
            return Err(too_many(bytes, self));
        }
        Ok(Growth::Longer)
    }
}

impl Lists {
    /// The same for the lists of scheme blocks.
    fn grow_batches(&mut self, state: &mut State) -> Result<Growth> {
        let (need, near) = (need(state), need(state).required_near.next_multiple_of(NEAR_PART));
        state.data.object_params.iter_mut().for_each(|params| params.near_capacity = params.near_capacity.max(near));
        let (need, each) = (need.required_entries as usize, state.largest_batch().max(1));
        let most = self.most_entries();
        if need > most && each == 1 {
            let what = format!("one block of receivers needs {need} entries, a binding of the device takes {most}");
            return Err(Error::device("making room for buffer entries", what));
        }
        let growth = if need > most { Growth::SmallerParts } else { Growth::Longer };
        if need > most {
            self.batch_blocks = (each as f64 * most as f64 / need as f64 * 0.75).max(1.0) as usize;
            self.batches(state, most / self.batch_blocks);
        } else if need > state.data.object_params[0].entry_capacity as usize {
            let capacity = (need + need / 32).next_multiple_of(64).min(most) as u32;
            state.data.object_params.iter_mut().for_each(|params| params.entry_capacity = capacity);
        }
        let bytes = 4 * u64::from(state.data.object_params[0].entry_capacity) * state.batch_count() as u64;
        if state.keep && bytes > self.allocation {
            return Err(too_many(bytes, self));
        }
        Ok(growth)
    }
}

/// The error of lists that are too long to keep.
fn too_many(bytes: u64, lists: &Lists) -> Error {
    let Lists { allocation, limited_by, .. } = *lists;
    Error::TooMuchToKeep { what: format!("they take {bytes} bytes or more, {limited_by} {allocation}"), limited_by }
}

/// Faces of the largest chunk.
fn largest_chunk(prepared: &Prepared) -> usize {
    let chunks = prepared.state.objects.iter().flat_map(|object| &object.schedule.chunks);
    chunks.map(|chunk| chunk.nodes.len()).max().unwrap_or(0).div_ceil(2)
}

/// The largest length that any object required of each list.
pub(crate) fn need(state: &State) -> ListCounters {
    let most = |of: fn(&ListCounters) -> u32| state.data.counters.iter().map(of).max().unwrap_or(0);
    ListCounters {
        required_links: most(|c| c.required_links),
        required_areas: most(|c| c.required_areas),
        required_edges: most(|c| c.required_edges),
        required_hands: most(|c| c.required_hands),
        required_entries: most(|c| c.required_entries),
        required_near: most(|c| c.required_near),
        ..ListCounters::default()
    }
}

/// Sets the capacities for links, area-point links, edge-form links, and hand-downs.
fn set(prepared: &mut Prepared, capacities: [u32; 4]) {
    for params in &mut prepared.state.data.object_params {
        [params.link_capacity, params.area_capacity, params.edge_capacity, params.hand_capacity] = capacities;
        params.edit_capacity = params.edit_capacity.max(capacities[0] / 16).max(64);
    }
}
