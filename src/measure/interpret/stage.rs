//! The dispatches of a stage on the interpreter: the same list that a device would get, on copies of the state's
//! buffers. The device that they are made for shares items among [`LANES`] invocations and has subgroups of
//! [`SUBGROUP`], unless [`Settings`] say otherwise.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::memory::is_undefined;
use super::{Finding, Kernel, Launched, MOST_BLOCKS, Memory, Part, Suspects};
use crate::error::{Error, Result};
use crate::gpu::count::{BINDING, Block, Counted, Tally, counted};
use crate::gpu::{KernelKey, most_lanes, set_by_device, words_of};
use crate::layout::{BUFFER_IDS, BufferId, GROUPS_A_ROW, MOST_LANES, MOST_WIDE, WIDE_ID};
use crate::state::{Call, Groups, State, Step, Width, requested};

/// Invocations that share an item, in kernels that can.
pub const LANES: u32 = MOST_LANES;
/// Invocations of a subgroup.
pub const SUBGROUP: u32 = 32;

/// How kernels run.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Invocations that share an item, in kernels that can.
    pub lanes: u32,
    /// Invocations of a group that goes through all elements alone, where items are shared; at most [`MOST_WIDE`].
    pub wide: u32,
    /// Invocations of a subgroup.
    pub subgroup: u32,
    /// Whether kernels count what they do, as on a device.
    pub counts: bool,
    /// Whether sums take products in one step, as many compilers have it, wherever nothing forbids it.
    pub contracts: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { lanes: LANES, wide: LANES, subgroup: SUBGROUP, counts: false, contracts: false }
    }
}

impl Settings {
    /// Those of a GPU, with kernels that count what they do.
    #[must_use]
    pub fn counting() -> Self {
        Self { wide: MOST_WIDE, counts: true, ..Self::default() }
    }

    /// The width of the device that this makes.
    #[must_use]
    pub fn width(self) -> Width {
        Width { subgroup: self.subgroup as usize, shares: self.lanes > 1 }
    }
}

/// Kernels as the interpreter has them, each decoded once.
#[derive(Default)]
pub struct Interpreter {
    settings: Settings,
    /// The SPIR-V of kernels that do not come from the build, by name.
    replaced: BTreeMap<String, Vec<u32>>,
    prepared: RefCell<BTreeMap<KernelKey, Rc<Prepared>>>,
}

/// A kernel, and how its invocations share items.
struct Prepared {
    kernel: Kernel,
    /// Invocations of an item.
    an_item: u32,
    /// Whether the groups of an indirect dispatch are in the next element.
    shares: bool,
    /// The blocks that count, if it counts.
    counting: Option<Vec<Block>>,
}

/// What a step's dispatches have done.
#[derive(Default)]
pub struct Ran {
    /// The buffers that they bind, as they left them.
    buffers: Vec<(BufferId, Memory)>,
    /// Instructions of SPIR-V that invocations have executed.
    pub executed: u64,
    /// How many dispatches of at least one group there were.
    pub dispatches: usize,
    /// Their kernels.
    pub kernels: BTreeSet<String>,
    /// What each dispatch has done, after its kernel's name, where kernels count.
    pub tallies: Vec<(String, Tally)>,
    findings: Vec<Finding>,
    suspects: Vec<(Rc<Prepared>, Suspects)>,
}

impl Interpreter {
    /// The interpreter with these kernels in place of built-in ones.
    #[must_use]
    pub fn new(replaced: Vec<(String, Vec<u32>)>) -> Self {
        Self::with(Settings::default(), replaced)
    }

    /// The same with these settings.
    #[must_use]
    pub fn with(settings: Settings, replaced: Vec<(String, Vec<u32>)>) -> Self {
        Self { settings, replaced: replaced.into_iter().collect(), ..Self::default() }
    }

    /// How its kernels run.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// The kernels that do not come from the build.
    pub fn replaced(&self) -> impl Iterator<Item = &str> {
        self.replaced.keys().map(String::as_str)
    }

    /// The kernels that were asked to run.
    #[must_use]
    pub fn asked(&self) -> BTreeSet<String> {
        self.prepared.borrow().keys().map(|key| key.name.clone()).collect()
    }

    /// Runs a step's dispatches on copies of the state's buffers; if they are `watched`, finds what is wrong.
    pub fn run(&self, state: &State, step: Step, watched: bool) -> Result<Ran> {
        let mut ran = Ran::default();
        requested(state, step, self.settings.width(), &mut |call| self.dispatch(state, call, &mut ran, watched))?;
        Ok(ran)
    }

    fn dispatch(&self, state: &State, call: &Call<'_>, ran: &mut Ran, watched: bool) -> Result<()> {
        let prepared = self.prepared(call.kernel, call.constants)?;
        let count = prepared.counting.as_ref().map_or(0, |blocks| Counted::counters(blocks));
        let counters = Memory::of(&vec![0; 4 * count]);
        match ran.groups(state, call, &prepared, watched) {
            None => return Ok(()),
            // A device has counters for what it finds to have no groups.
            Some(groups) if groups.contains(&0) => {
                if !matches!(call.groups, Groups::Counted { .. }) {
                    return Ok(());
                }
            }
            Some(groups) => self.launch(state, (call, groups), (&prepared, &counters), ran, watched)?,
        }
        if let Some(blocks) = &prepared.counting {
            let counters: Vec<u32> = (0..count).map(|word| counters.get(word)).collect();
            ran.tallies.push((call.kernel.to_string(), Tally::new(blocks, &counters)));
        }
        Ok(())
    }

    /// Runs groups of a dispatch; what they count goes to `counters`.
    fn launch(
        &self,
        state: &State,
        (call, groups): (&Call<'_>, [u32; 3]),
        (prepared, counters): (&Rc<Prepared>, &Memory),
        ran: &mut Ran,
        watched: bool,
    ) -> Result<()> {
        let mut bound = BTreeMap::new();
        for binding in prepared.kernel.bindings().iter().filter(|binding| **binding != BINDING) {
            let doing = || format!("interpreting kernel {}", call.kernel);
            let id = BUFFER_IDS.get(*binding as usize);
            let id = id.ok_or_else(|| Error::device(doing(), format!("nothing is bound at {binding}")))?;
            bound.insert(*binding, ran.part(state, state.data.bound(*id), call));
        }
        ran.dispatches += 1;
        ran.kernels.insert(call.kernel.to_string());
        let mut memory: Vec<&Memory> = ran.buffers.iter().map(|(_, memory)| memory).collect();
        bound.insert(BINDING, Part { memory: memory.len(), first: 0, count: counters.len() });
        memory.push(counters);
        let (push, bound, memory, subgroup) = (call.push, &bound, &memory[..], self.settings.subgroup);
        let launched = Launched { groups, push, bound, memory, subgroup, most_blocks: MOST_BLOCKS };
        if watched {
            let (executed, findings, suspects) = prepared.kernel.watched(&launched)?;
            ran.executed += executed;
            ran.findings.extend(findings);
            ran.suspects.push((prepared.clone(), suspects));
        } else {
            ran.executed += prepared.kernel.run(&launched)?;
        }
        Ok(())
    }

    fn prepared(&self, name: &str, constants: &[u32]) -> Result<Rc<Prepared>> {
        let key = KernelKey { name: name.to_string(), constants: constants.to_vec() };
        if let Some(known) = self.prepared.borrow().get(&key) {
            return Ok(known.clone());
        }
        let words = match self.replaced.get(name) {
            Some(words) => words.clone(),
            None => words_of(name)?,
        };
        let shape = |lanes: u32| set_by_device(name, &words, lanes);
        let shape = match shape(self.settings.lanes.min(most_lanes(name))) {
            own if matches!(own[..], [_, (WIDE_ID, _)]) => shape(self.settings.wide),
            own => own,
        };
        let counted = if self.settings.counts { counted(&words) } else { None };
        let (words, counting) = counted.map_or((words, None), |own| (own.words, Some(own.blocks)));
        let special = (0..).zip(constants.iter().copied()).chain(shape.iter().copied()).collect();
        let kernel = Kernel::with(name, &words, &special, self.settings.contracts)?;
        // The size of its groups, and what tells the kernel how items are shared.
        let (an_item, shares) = match shape[..] {
            [_, (_, count)] => (count, true),
            _ => (1, false),
        };
        let prepared = Rc::new(Prepared { kernel, an_item, shares, counting });
        self.prepared.borrow_mut().insert(key, prepared.clone());
        Ok(prepared)
    }
}

impl Ran {
    /// The groups of a dispatch; none where they are counted by words that nothing wrote, which is a finding.
    fn groups(&mut self, state: &State, call: &Call<'_>, prepared: &Prepared, watched: bool) -> Option<[u32; 3]> {
        let group = u64::from(prepared.kernel.group());
        Some(match call.groups {
            Groups::Invocations(count) => {
                let groups = (count as u64 * u64::from(prepared.an_item)).div_ceil(group);
                let row = u64::from(GROUPS_A_ROW);
                [groups.min(row), groups.div_ceil(row), 1].map(|count| count as u32)
            }
            Groups::Whole(count) => [count as u32, 1, 1],
            Groups::Counted { slot, element } => {
                let Part { memory, first, .. } = self.part(state, slot, call);
                let words = slot.spec().stride / 4 * (element + usize::from(prepared.shares));
                let (from, memory) = (first + words, &self.buffers[memory].1);
                let counts = [0, 1, 2].map(|k| if from + k < memory.len() { memory.get(from + k) } else { 0 });
                if watched && counts.into_iter().any(is_undefined) {
                    let name = slot.spec().name;
                    let what = format!("the groups are counted by words of {name} that nothing wrote: {counts:#x?}");
                    self.findings.push(prepared.kernel.uncounted(what));
                    return None;
                }
                counts
            }
        })
    }

    /// The part of a buffer that a dispatch binds; the buffer is copied when it is first bound.
    fn part(&mut self, state: &State, id: BufferId, call: &Call<'_>) -> Part {
        let known = self.buffers.iter().position(|(known, _)| *known == id);
        let memory = known.unwrap_or_else(|| {
            self.buffers.push((id, Memory::of(state.data.bytes(id))));
            self.buffers.len() - 1
        });
        let (first, count) = state.part(id, call.at);
        let [first, count] = [first, count].map(|elements| elements * id.spec().stride / 4);
        Part { memory, first, count }
    }

    /// Copies the buffers to a state of the same sizes.
    pub fn write(&self, state: &mut State) {
        self.buffers.iter().for_each(|(id, memory)| memory.write(state.data.bytes_mut(*id)));
    }

    /// What was found wrong, once it is known what the reference makes of the step.
    #[must_use]
    pub fn findings(mut self, reference: &State) -> Vec<Finding> {
        for (prepared, suspects) in &self.suspects {
            for ((memory, word), by) in suspects {
                let (id, memory) = &self.buffers[*memory];
                let right = Memory::of(state_bytes(reference, *id, *word)).float(0);
                let (Some(value), Some(right)) = (memory.float(*word), right) else { continue };
                if value.is_finite() || !right.is_finite() {
                    continue;
                }
                let (spec, stride) = (id.spec(), id.spec().stride / 4);
                let place = format!("{}[{}], word {} of {stride}", spec.name, word / stride, word % stride);
                let what = format!("{value} to {place}, where the reference has {right}");
                let finding = prepared.kernel.not_finite(*by, &what);
                let same = |known: &&mut Finding| known.kind == finding.kind && known.site == finding.site;
                match self.findings.iter_mut().find(same) {
                    Some(known) => known.times += 1,
                    None => self.findings.push(finding),
                }
            }
        }
        self.findings
    }
}

/// The bytes of a word of a buffer, none where it has fewer.
fn state_bytes(state: &State, id: BufferId, word: usize) -> &[u8] {
    state.data.bytes(id).get(4 * word..4 * word + 4).unwrap_or_default()
}
