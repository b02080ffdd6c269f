//! What a planned frame requires, without running it: dispatches, kernels with their constants, bound buffers.

use std::collections::{BTreeMap, BTreeSet};

use super::run::Session;
use crate::error::Result;
use crate::gpu::constants;
use crate::layout::{BUFFER_IDS, BufferId};
use crate::pipeline::plan::Changes;
use crate::state::Bound;

/// What a stage requires in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageRequirements {
    /// The stage.
    pub stage: &'static str,
    /// How often it runs: once per object, chunk, group or batch.
    pub steps: usize,
    /// Dispatches of all its steps.
    pub dispatches: usize,
    /// Bytes bound for reading and for writing, each byte counted once. Lists count with their capacity.
    pub bytes: [u64; 2],
    /// Its pipelines.
    pub kernels: Vec<KernelRequirements>,
}

/// A pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelRequirements {
    /// The kernel.
    pub name: String,
    /// Its specialization constants.
    pub constants: Vec<u32>,
    /// How often it is dispatched.
    pub dispatches: usize,
}

impl KernelRequirements {
    /// The constants with their names: `CHANNELS = 7, ORDER = 2`.
    pub fn specialized(&self) -> Result<String> {
        let named = constants(&self.name)?.into_iter().zip(&self.constants);
        Ok(named.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", "))
    }
}

impl Session {
    /// What each stage requires in a frame after this change, in the order of the frame.
    pub fn needs(&self, changes: impl Into<Changes>) -> Result<Vec<StageRequirements>> {
        let changes = changes.into();
        let mut needs: Vec<StageRequirements> = Vec::new();
        for step in self.plan.steps(self.state(), changes.clone()) {
            match needs.iter_mut().find(|known| known.stage == step.stage.name) {
                Some(known) => known.steps += 1,
                None => {
                    needs.push(StageRequirements { stage: step.stage.name, steps: 1, ..StageRequirements::default() })
                }
            }
        }
        let mut ranges: BTreeMap<(&str, BufferId, bool), BTreeSet<[u64; 2]>> = BTreeMap::new();
        for dispatch in self.dispatches(changes)? {
            let Some(stage) = needs.iter_mut().find(|known| known.stage == dispatch.stage) else { continue };
            stage.dispatches += 1;
            let same = |known: &&mut KernelRequirements| {
                known.name == dispatch.kernel && known.constants == dispatch.constants
            };
            match stage.kernels.iter_mut().find(same) {
                Some(known) => known.dispatches += 1,
                None => stage.kernels.push(KernelRequirements {
                    name: dispatch.kernel.clone(),
                    constants: dispatch.constants.clone(),
                    dispatches: 1,
                }),
            }
            for Bound { slot, range, reads, writes } in dispatch.bound(self.state())? {
                for (written, does) in [(false, reads), (true, writes)] {
                    if does {
                        ranges.entry((dispatch.stage, slot, written)).or_default().insert(range);
                    }
                }
            }
        }
        for ((stage, _, written), ranges) in ranges {
            if let Some(stage) = needs.iter_mut().find(|known| known.stage == stage) {
                stage.bytes[usize::from(written)] += union(ranges);
            }
        }
        Ok(needs)
    }

    /// Buffers of which a dispatch in a frame after this change would bind more than the device allows.
    pub fn misfits(&self, changes: impl Into<Changes>) -> Result<BTreeSet<BufferId>> {
        let Some(limits) = self.limits() else { return Ok(BTreeSet::new()) };
        let most = limits.binding_bytes;
        let mut found = BTreeSet::new();
        for dispatch in self.dispatches(changes)? {
            let bound = dispatch.bound(self.state())?.into_iter();
            found.extend(bound.filter(|bound| bound.range[1] - bound.range[0] > most).map(|bound| bound.slot));
        }
        Ok(found)
    }

    /// The state's non-empty buffers, with their bytes.
    pub fn buffers(&self) -> Vec<(BufferId, u64)> {
        let sized = BUFFER_IDS.iter().map(|&id| (id, self.state().data.bytes(id).len() as u64));
        sized.filter(|(_, bytes)| *bytes > 0).collect()
    }
}

/// Bytes in the union of these ranges, each given by begin and end.
pub fn union(ranges: BTreeSet<[u64; 2]>) -> u64 {
    let (mut sum, mut end) = (0, 0);
    for [first, last] in ranges {
        sum += last.saturating_sub(first.max(end));
        end = end.max(last);
    }
    sum
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_byte_bound_twice_counts_once() {
        assert_eq!(super::union([[10, 20], [0, 4], [15, 25], [16, 18]].into()), 19);
        assert_eq!(super::union([].into()), 0);
    }
}
