//! What is wrong with how a kernel uses memory and barriers, found while it runs.
//!
//! Two accesses to a word race if at least one writes, not both are atomic, and no order between them is certain. Each
//! invocation has a clock that goes on at barriers of memory. Of each other invocation it knows up to which time it has
//! to see its accesses: by a barrier of the group or the subgroup, or by an atomic operation on a word that the other
//! one changed before, if both have a barrier of memory between that and their accesses.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use super::code::{Code, Pointer, Site};
use super::memory::{UNDEFINED, UNDEFINED_SHARED, is_undefined};
use super::run::Place;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Two invocations access a word in no certain order.
    Race,
    /// An access beyond the end of a buffer as bound, or of an array.
    Bounds,
    /// The use of a value that nothing wrote.
    Undefined,
    /// A barrier that not all invocations reach together, or an exchange with one that is elsewhere.
    Divergence,
    /// A result that is not finite, where the reference's is.
    NotFinite,
}

impl Kind {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Race => "data race",
            Self::Bounds => "out of bounds",
            Self::Undefined => "uninitialised value",
            Self::Divergence => "non-uniform flow",
            Self::NotFinite => "not finite",
        }
    }
}

/// Something wrong in a kernel, as it was found first.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What is wrong.
    pub kind: Kind,
    /// The kernel.
    pub kernel: String,
    /// The instruction.
    pub site: Site,
    /// What happened: invocations, and the element.
    pub what: String,
    /// How often it was found.
    pub times: u64,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { kind, kernel, site, what, times } = self;
        write!(out, "{}: {kernel}: {site}: {what}", kind.name())?;
        if *times > 1 { write!(out, "; {times} times") } else { Ok(()) }
    }
}

/// How a word is accessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Touch {
    Read,
    Write,
    /// By an atomic operation with these semantics.
    Atomic {
        semantics: u32,
        reads: bool,
        writes: bool,
    },
}

impl Touch {
    /// What an invocation does, in words.
    fn name(self) -> &'static str {
        match self {
            Self::Read | Self::Atomic { writes: false, .. } => "reads",
            Self::Write | Self::Atomic { reads: false, .. } => "writes",
            Self::Atomic { .. } => "changes",
        }
    }

    fn writes(self) -> bool {
        !matches!(self, Self::Read | Self::Atomic { writes: false, .. })
    }
}

/// What orders accesses of a class of memory: a bit of semantics. The first class is the group's memory, the second
/// one that of buffers.
const CLASSES: [u32; 2] = [0x100, 0x40];
/// Bits of semantics by which earlier accesses are seen by others, and by which later ones see those of others.
const RELEASES: u32 = 4 | 8 | 16;
const ACQUIRES: u32 = 2 | 8 | 16;
/// The scope of a subgroup.
const SUBGROUP: u32 = 3;

/// An access: the invocation, its time, and the instruction.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Mark {
    invocation: u32,
    time: u32,
    at: u32,
    atomic: bool,
}

const NOBODY: Mark = Mark { invocation: u32::MAX, time: 0, at: 0, atomic: false };

/// The last accesses of a word: the write, the first read after it, and the latest read by another invocation.
#[derive(Clone, Copy)]
struct Shadow {
    write: Mark,
    reads: [Mark; 2],
}

const UNTOUCHED: Shadow = Shadow { write: NOBODY, reads: [NOBODY; 2] };
/// Words of a buffer whose shadows are together.
const PAGE: usize = 256;

/// Up to which time which invocations are seen.
type Seen = Rc<BTreeMap<u32, u32>>;

/// The clocks of an invocation.
#[derive(Clone, Default)]
struct Clock {
    now: u32,
    /// For each class, up to when its accesses are seen by all that come to know of it, by the group, the subgroup.
    released: [u32; 2],
    by_group: [u32; 2],
    by_subgroup: [u32; 2],
    /// The same by those of the subgroup that were at its last barrier when not all were, and who these were: bits.
    by_some: [u32; 2],
    some: u128,
    /// What it sees of others, what it will see after the next barrier of memory, and what it lets others see.
    seen: Seen,
    coming: Vec<Seen>,
    shown: Seen,
}

/// Words of buffers, by the buffer's place and the word's; the instruction that wrote each, and the invocation.
pub(super) type Suspects = BTreeMap<(usize, usize), (u32, u32)>;

/// Watches a dispatch.
pub(super) struct Watch<'a> {
    kernel: &'a str,
    code: &'a Code,
    lanes: u32,
    subgroup: u32,
    group: u32,
    clocks: Vec<Clock>,
    buffers: HashMap<(usize, usize), Box<[Shadow; PAGE]>>,
    shared: Vec<Shadow>,
    /// What invocations that changed a word by an atomic operation let others see.
    changed: HashMap<Place, Seen>,
    /// Where each invocation loaded a word that nothing had written: the instruction, the variable and the word.
    origins: Vec<Option<(u32, u32, usize)>>,
    /// Words of buffers that became infinite or NaN, and by what.
    pub(super) infinite: Suspects,
    found: HashMap<(Kind, u32, u32), usize>,
    pub(super) findings: Vec<Finding>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(kernel: &'a str, code: &'a Code, subgroup: u32) -> Self {
        let lanes = code.group.iter().product::<u32>();
        Self {
            kernel,
            code,
            lanes,
            subgroup,
            group: 0,
            clocks: vec![Clock::default(); lanes as usize],
            buffers: HashMap::new(),
            shared: vec![UNTOUCHED; code.shared as usize],
            changed: HashMap::new(),
            origins: vec![None; lanes as usize],
            infinite: Suspects::new(),
            found: HashMap::new(),
            findings: Vec::new(),
        }
    }

    /// A group begins.
    pub(super) fn begin(&mut self, number: u32) {
        self.group = number;
        self.clocks.fill(Clock { now: 1, ..Clock::default() });
        self.shared.fill(UNTOUCHED);
        self.changed.retain(|place, _| matches!(place, Place::Buffer { .. }));
        self.origins.fill(None);
    }

    /// Adds a finding, or counts it if the same instructions were found before.
    fn add(&mut self, kind: Kind, (at, other): (u32, u32), what: impl FnOnce(&Self) -> String) {
        if let Some(known) = self.found.get(&(kind, at, other)) {
            self.findings[*known].times += 1;
            return;
        }
        let (site, kernel) = (self.code.places[at as usize].clone(), self.kernel.to_string());
        let finding = Finding { kind, kernel, site, what: what(self), times: 1 };
        self.found.insert((kind, at, other), self.findings.len());
        self.findings.push(finding);
    }

    /// An invocation of the group in words.
    fn name(&self, lane: u16) -> String {
        self.named(self.group * self.lanes + u32::from(lane))
    }

    fn named(&self, invocation: u32) -> String {
        format!("invocation {} of group {}", invocation % self.lanes, invocation / self.lanes)
    }

    /// A word of a variable in words.
    fn element(&self, variable: u32, word: usize) -> String {
        let variable = &self.code.variables[variable as usize];
        let (element, rest) = (word / variable.stride as usize, word % variable.stride as usize);
        let inner = if variable.stride > 1 { format!(", word {rest} of {}", variable.stride) } else { String::new() };
        match variable.count {
            1 => format!("{}{inner}", variable.name),
            _ => format!("{}[{element}]{inner}", variable.name),
        }
    }

    /// An invocation accesses a word.
    pub(super) fn touch(&mut self, place: Place, variable: u32, word: usize, (lane, touch, at): (u16, Touch, u32)) {
        let class = match place {
            Place::Buffer { .. } => 1,
            Place::Shared(_) => 0,
            Place::Register(_) => return,
        };
        let semantics = if let Touch::Atomic { semantics, .. } = touch { semantics } else { 0 };
        if semantics & RELEASES != 0 {
            self.pass(lane, semantics);
        }
        let shadow = *self.shadow(place);
        let clock = &self.clocks[lane as usize];
        let atomic = matches!(touch, Touch::Atomic { .. });
        let own = Mark { invocation: self.group * self.lanes + u32::from(lane), time: clock.now, at, atomic };
        // Reads race with writes only; two atomic operations with each other never do.
        let reads = shadow.reads.into_iter().filter(|_| touch.writes());
        let racing = std::iter::once(shadow.write)
            .chain(reads)
            .find(|mark| *mark != NOBODY && !(mark.atomic && atomic) && !self.is_ordered(*mark, class, lane));
        if let Some(mark) = racing {
            let reads = mark != shadow.write;
            self.add(Kind::Race, (at, mark.at), |watch| {
                let does = touch.name();
                let did = if reads { "reads" } else { "writes" };
                let (here, element) = (watch.name(lane), watch.element(variable, word));
                let (there, site) = (watch.named(mark.invocation), &watch.code.places[mark.at as usize]);
                format!("{here} {does} {element}, which {there} {did} at {site}, in no certain order")
            });
        }
        let shadow = self.shadow(place);
        let first = shadow.reads[0];
        if touch.writes() {
            *shadow = Shadow { write: own, reads: [NOBODY; 2] };
        } else {
            shadow.reads[usize::from(first != NOBODY && first.invocation != own.invocation)] = own;
        }
        if let Touch::Atomic { reads, writes, .. } = touch {
            self.meet(place, lane, (reads, writes));
            if semantics & ACQUIRES != 0 {
                self.pass(lane, semantics);
            }
        }
    }

    fn shadow(&mut self, place: Place) -> &mut Shadow {
        match place {
            Place::Buffer { memory, word } => {
                let page = self.buffers.entry((memory, word / PAGE)).or_insert_with(|| Box::new([UNTOUCHED; PAGE]));
                &mut page[word % PAGE]
            }
            Place::Shared(word) | Place::Register(word) => &mut self.shared[word],
        }
    }

    /// Whether an invocation of the group surely comes after this access.
    fn is_ordered(&self, mark: Mark, class: usize, lane: u16) -> bool {
        let (group, there) = (mark.invocation / self.lanes, mark.invocation % self.lanes);
        if group == self.group {
            let (own, size) = (&self.clocks[there as usize], self.subgroup);
            let near = there / size == u32::from(lane) / size && mark.time <= own.by_subgroup[class];
            let beside = own.some >> (u32::from(lane) % size) & 1 == 1 && there / size == u32::from(lane) / size;
            let beside = beside && mark.time <= own.by_some[class];
            if there == u32::from(lane) || mark.time <= own.by_group[class] || near || beside {
                return true;
            }
        }
        self.clocks[lane as usize].seen.get(&mark.invocation).is_some_and(|time| mark.time <= *time)
    }

    /// An atomic operation: an invocation that writes lets others see what it has passed a barrier for; one that reads
    /// comes to see theirs. What is written without being read is the word of that invocation alone.
    fn meet(&mut self, place: Place, lane: u16, (reads, writes): (bool, bool)) {
        let own = self.group * self.lanes + u32::from(lane);
        let clock = &mut self.clocks[lane as usize];
        let known = self.changed.entry(place).or_default();
        if !reads {
            *known = Seen::default();
        }
        if !known.is_empty() {
            clock.coming.push(known.clone());
        }
        let released = clock.released[1];
        if writes && released > 0 {
            let all = Rc::make_mut(known);
            union(all, &clock.shown);
            all.insert(own, released);
        }
    }

    /// A barrier of memory for one invocation.
    fn pass(&mut self, lane: u16, semantics: u32) {
        let clock = &mut self.clocks[lane as usize];
        for (class, bit) in CLASSES.into_iter().enumerate() {
            if semantics & bit != 0 {
                clock.released[class] = clock.now;
            }
        }
        for coming in std::mem::take(&mut clock.coming) {
            if clock.seen.is_empty() {
                clock.seen = coming;
            } else {
                union(Rc::make_mut(&mut clock.seen), &coming);
            }
        }
        clock.shown = clock.seen.clone();
        clock.now += 1;
    }

    /// A barrier of memory alone. One for subgroups only counts with a barrier that their invocations reach.
    pub(super) fn fence(&mut self, scope: u32, semantics: u32, lanes: &[u16]) {
        if scope != SUBGROUP && semantics & (RELEASES | ACQUIRES) != 0 {
            lanes.iter().for_each(|lane| self.pass(*lane, semantics));
        }
    }

    /// A barrier of the group or the subgroup, which also orders memory. One of a subgroup waits for those of its
    /// invocations that are there; that of a group is for all.
    pub(super) fn barrier(&mut self, scope: u32, semantics: u32, lanes: &[u16], at: u32) {
        if scope != SUBGROUP && lanes.len() < self.lanes as usize {
            let missing = (0..self.lanes as u16).find(|lane| lanes.binary_search(lane).is_err()).unwrap_or_default();
            self.diverges(lanes[0], at, |watch| format!("reaches the barrier without {}", watch.name(missing)));
        }
        lanes.iter().for_each(|lane| self.pass(*lane, semantics));
        if scope == SUBGROUP {
            let size = self.subgroup as u16;
            lanes.chunk_by(|a, b| a / size == b / size).for_each(|own| self.together(own));
            return;
        }
        for lane in lanes {
            let clock = &mut self.clocks[*lane as usize];
            clock.by_group = clock.released;
        }
        // What one has seen of other groups, all have seen.
        if lanes.iter().any(|lane| !self.clocks[*lane as usize].seen.is_empty()) {
            let mut all = BTreeMap::new();
            lanes.iter().for_each(|lane| union(&mut all, &self.clocks[*lane as usize].seen));
            let all = Rc::new(all);
            for lane in lanes {
                let clock = &mut self.clocks[*lane as usize];
                (clock.seen, clock.shown) = (all.clone(), all.clone());
            }
        }
    }

    /// A barrier of these invocations, which are of one subgroup.
    fn together(&mut self, lanes: &[u16]) {
        let first = u32::from(lanes[0]) / self.subgroup * self.subgroup;
        let whole = lanes.len() as u32 == self.subgroup.min(self.lanes - first);
        let some = lanes.iter().fold(0, |some, lane| some | 1u128 << (u32::from(*lane) - first));
        for lane in lanes {
            let clock = &mut self.clocks[*lane as usize];
            match whole {
                true => clock.by_subgroup = clock.released,
                false => (clock.by_some, clock.some) = (clock.released, some),
            }
        }
    }

    /// An invocation accesses what is beyond the end of a variable.
    pub(super) fn beyond(&mut self, pointer: &Pointer, word: usize, index: bool, (lane, touch, at): (u16, Touch, u32)) {
        self.add(Kind::Bounds, (at, at), |watch| {
            let does = touch.name();
            let element = watch.element(pointer.variable, word);
            let end = match watch.code.variables[pointer.variable as usize].count {
                _ if index => "an index is not less than the length of its array".to_string(),
                _ => "beyond the end of what is bound".to_string(),
            };
            format!("{} {does} {element}: {end}", watch.name(lane))
        });
    }

    /// An invocation has loaded a word.
    pub(super) fn loaded(&mut self, value: u32, pointer: &Pointer, (lane, at): (u16, u32), place: Option<Place>) {
        if is_undefined(value) && place.is_some() {
            let word = pointer.fixed as usize;
            self.origins[lane as usize] = Some((at, pointer.variable, word));
        }
    }

    /// An invocation has stored a word in a buffer.
    pub(super) fn stored(&mut self, value: u32, floats: bool, place: (usize, usize), (lane, at): (u16, u32)) {
        if floats && !f32::from_bits(value).is_finite() {
            self.infinite.insert(place, (at, self.group * self.lanes + u32::from(lane)));
        } else if !self.infinite.is_empty() {
            self.infinite.remove(&place);
        }
    }

    /// Whether an invocation is about to use a value that nothing wrote.
    pub(super) fn undefined(&mut self, value: u32, lane: u16, at: u32) -> bool {
        if !is_undefined(value) {
            return false;
        }
        let origin = self.origins[lane as usize].filter(|_| value != UNDEFINED);
        self.add(Kind::Undefined, (at, at), |watch| {
            let of = match (value, origin) {
                (_, Some((from, variable, _))) => {
                    let (name, site) =
                        (&watch.code.variables[variable as usize].name, &watch.code.places[from as usize]);
                    format!("a word of {name} that nothing wrote, loaded at {site}")
                }
                (UNDEFINED, _) => "a variable of its own that nothing wrote".into(),
                (UNDEFINED_SHARED, _) => "a shared variable that nothing wrote".into(),
                _ => "memory that nothing wrote".into(),
            };
            format!("{} uses {of}", watch.name(lane))
        });
        true
    }

    /// An invocation does what others that are elsewhere have to take part in.
    pub(super) fn diverges(&mut self, lane: u16, at: u32, does: impl FnOnce(&Self) -> String) {
        self.add(Kind::Divergence, (at, at), |watch| format!("{} {}", watch.name(lane), does(watch)));
    }
}

/// Adds what another one sees.
fn union(all: &mut BTreeMap<u32, u32>, other: &BTreeMap<u32, u32>) {
    for (invocation, time) in other {
        let known = all.entry(*invocation).or_default();
        *known = (*known).max(*time);
    }
}
