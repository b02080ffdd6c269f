//! A kernel that the interpreter can run.

use std::collections::BTreeMap;

use super::code::{Code, Site};
use super::memory::{Launched, Part};
use super::run::Launch;
use super::watch::{Finding, Kind, Suspects, Watch};
use crate::error::{Error, Result};
use crate::gpu::words_in;

/// Most blocks that a group runs.
pub const MOST_BLOCKS: u64 = 1 << 26;
/// Most invocations of a group.
const MOST_INVOCATIONS: u32 = 1024;
/// Most numbers of all invocations of a group.
const MOST_NUMBERS: u64 = 1 << 26;
/// Most groups of each dimension: what every device has.
const MOST_GROUPS: u32 = 65_535;
/// Sizes that a subgroup can have.
const SUBGROUPS: std::ops::RangeInclusive<u32> = 1..=128;

/// A kernel.
pub struct Kernel {
    name: String,
    code: Code,
}

impl Kernel {
    /// The kernel of this SPIR-V with these values of specialization constants, by their ids; fails where it has what
    /// the interpreter has not.
    pub fn new(name: &str, words: &[u32], special: &BTreeMap<u32, u32>) -> Result<Self> {
        Self::with(name, words, special, false)
    }

    /// The same; if it `contracts`, a sum takes a product in one step, rounded once, wherever nothing forbids it.
    pub fn with(name: &str, words: &[u32], special: &BTreeMap<u32, u32>, contracts: bool) -> Result<Self> {
        let fault = |what: String| Error::device(format!("interpreting kernel {name}"), what);
        let code = super::builder::decoded(words, special, contracts).map_err(fault)?;
        let count = code.group.iter().try_fold(1u32, |all, count| all.checked_mul(*count));
        if !count.is_some_and(|count| (1..=MOST_INVOCATIONS).contains(&count)) {
            return Err(fault(format!(
                "its groups are {:?}; they have at most {MOST_INVOCATIONS} invocations",
                code.group
            )));
        }
        if u64::from(code.registers) * u64::from(code.group.iter().product::<u32>()) > MOST_NUMBERS {
            return Err(fault("its groups have too many numbers".into()));
        }
        Ok(Self { name: name.into(), code })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Invocations of a group.
    #[must_use]
    pub fn group(&self) -> u32 {
        self.code.group.iter().product()
    }

    /// Runs a dispatch; returns how many instructions of SPIR-V its invocations have executed together.
    pub fn run(&self, launched: &Launched<'_>) -> Result<u64> {
        self.launch(launched, None)
    }

    /// Runs a dispatch and watches it: also returns what is wrong, and which words of buffers became infinite or NaN.
    pub(super) fn watched(&self, launched: &Launched<'_>) -> Result<(u64, Vec<Finding>, Suspects)> {
        let mut watch = Watch::new(&self.name, &self.code, launched.subgroup);
        let executed = self.launch(launched, Some(&mut watch))?;
        Ok((executed, watch.findings, watch.infinite))
    }

    /// Runs a dispatch and returns what is wrong with its use of memory and barriers.
    pub fn findings(&self, launched: &Launched<'_>) -> Result<Vec<Finding>> {
        Ok(self.watched(launched)?.1)
    }

    /// The finding that an instruction and an invocation left a word infinite or NaN.
    pub(super) fn not_finite(&self, (at, invocation): (u32, u32), what: &str) -> Finding {
        let (lane, group) = (invocation % self.group(), invocation / self.group());
        let what = format!("invocation {lane} of group {group} writes {what}");
        let site = self.code.places[at as usize].clone();
        Finding { kind: Kind::NotFinite, kernel: self.name.clone(), site, what, times: 1 }
    }

    /// The finding that it is dispatched by a count of groups that nothing wrote.
    pub(super) fn uncounted(&self, what: String) -> Finding {
        let site = Site { instruction: "vkCmdDispatchIndirect".into(), ..Site::default() };
        Finding { kind: Kind::Undefined, kernel: self.name.clone(), site, what, times: 1 }
    }

    /// The bindings of its buffers.
    pub(super) fn bindings(&self) -> &[u32] {
        &self.code.buffers
    }

    fn launch(&self, launched: &Launched<'_>, watch: Option<&mut Watch<'_>>) -> Result<u64> {
        let fault = |what: String| Error::device(format!("interpreting kernel {}", self.name), what);
        let push = words_in(launched.push);
        let takes = self.code.pushed.1 as usize;
        let push = push.get(..takes).ok_or_else(|| fault(format!("it takes {takes} words of push constants")))?;
        let part = |binding: &u32| {
            let part = launched.bound.get(binding).copied().filter(|part| part.memory < launched.memory.len());
            part.ok_or_else(|| fault(format!("nothing is bound at {binding}")))
        };
        let bound = self.code.buffers.iter().map(part).collect::<Result<Vec<Part>>>()?;
        if !SUBGROUPS.contains(&launched.subgroup) {
            return Err(fault(format!("subgroups of {} invocations", launched.subgroup)));
        }
        let groups = launched.groups;
        if groups.iter().any(|count| *count > MOST_GROUPS) {
            return Err(fault(format!(
                "a dispatch of {groups:?} groups; it has at most {MOST_GROUPS} of each dimension"
            )));
        }
        Launch { code: &self.code, asked: launched, push, bound: &bound }.run(watch).map_err(fault)
    }
}
