//! A dispatch, or a few of them in a row, as files that repeat it on any device without the rest of the program: what
//! it is given, what it should leave, how far that may be off, and what a device has left.
//!
//! - `trace`: runs a step of a fixture, and makes a [`Case`] of it;
//! - `isolate`: leaves those dispatches out that have no part in a failure;
//! - `together`: looks for failures that need the dispatches in one submission;
//! - `unfinished`: cases of dispatches that do not end, made before they run;
//! - `minimize`: leaves groups and ends of buffers out that have no part in it;
//! - `run`: runs a case on a device, and compares;
//! - `files`, `json`: a case as a folder, and back;
//! - `amber`: a case as an AmberScript.

pub mod amber;
pub mod files;
mod isolate;
mod json;
pub mod minimize;
pub mod run;
mod together;
pub mod trace;
pub mod unfinished;

use std::collections::BTreeSet;

/// The word need not agree with anything.
pub const ANY: f32 = -2.0;
/// The word must agree bit for bit.
pub const BITS: f32 = -1.0;

/// Dispatches that can be repeated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Case {
    /// Where it comes from.
    pub about: About,
    /// The parts of buffers that dispatches bind.
    pub buffers: Vec<Part>,
    /// The dispatches, in order.
    pub dispatches: Vec<Dispatch>,
}

/// Where a case comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// The stage.
    pub stage: String,
    /// What the stage does.
    pub does: String,
    /// The step: the stage with object, group and chunk.
    pub step: String,
    /// The fixture or scene.
    pub fixture: String,
    /// The device that it was run on.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// Why the tolerances are what they are.
    pub tolerance: String,
    /// Which dispatches of the step these are, and why.
    pub dispatches: String,
    /// Whether that device was beyond tolerance, or did not end.
    pub fails: bool,
    /// If that device did not end, by a hang, a crash or its loss: the limit for two runs in a process of their own,
    /// seconds.
    pub seconds: Option<f64>,
}

/// The part of a buffer that dispatches bind, with guard bytes behind it where they bind those too. All of it is whole
/// words.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// The buffer's name.
    pub name: String,
    /// The words of an element: path, and whether it is a float.
    pub words: Vec<(String, bool)>,
    /// The number of the first element.
    pub first: usize,
    /// What it holds before the first dispatch.
    pub before: Vec<u32>,
    /// What it should hold after the last one.
    pub expected: Vec<u32>,
    /// The largest difference allowed of each word, or [`BITS`] or [`ANY`].
    pub allowed: Vec<f32>,
    /// What the device left there.
    pub device: Vec<u32>,
}

/// A dispatch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dispatch {
    /// The kernel's name.
    pub kernel: String,
    /// Its SPIR-V as the driver was given it.
    pub spirv: Vec<u32>,
    /// Its specialization constants 0, 1, ...
    pub constants: Vec<u32>,
    /// Its push constants.
    pub push: Vec<u32>,
    /// Invocations that share an item; 0 counts as 1.
    pub lanes: u32,
    /// Groups in each dimension.
    pub groups: [u32; 3],
    /// The number of the first group, across; not 0 where the SPIR-V was changed to count from it.
    pub first_group: u32,
    /// What it binds.
    pub bindings: Vec<Bound>,
}

/// A buffer as a dispatch binds it, from its first byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bound {
    /// The binding, in set 0.
    pub number: u32,
    /// The buffer, as an index.
    pub buffer: usize,
    /// Bytes bound.
    pub bytes: u64,
    /// Whether the kernel may write it.
    pub writes: bool,
}

impl Part {
    /// The indices of the words that are beyond what is allowed.
    pub fn wrong<'a>(&'a self, found: &'a [u32]) -> impl Iterator<Item = usize> + 'a {
        let right = |k: usize| within(self.expected[k], found[k], self.allowed[k]);
        (0..self.expected.len()).filter(move |&k| !right(k))
    }

    /// A word's name: `radiosity[3].0`.
    #[must_use]
    pub fn place(&self, word: usize) -> String {
        let many = self.words.len().max(1);
        let path = self.words.get(word % many).map_or("", |(path, _)| path);
        let dot = if path.is_empty() { "" } else { "." };
        format!("{}[{}]{dot}{path}", self.name, self.first + word / many)
    }

    /// Expected and found value of a word, as text.
    #[must_use]
    pub fn values(&self, word: usize, found: u32) -> String {
        let float = self.words.get(word % self.words.len().max(1)).is_some_and(|(_, float)| *float);
        let show = |bits: u32| match float {
            true => format!("{:e} ({bits:#010x})", f32::from_bits(bits)),
            false => format!("{bits} ({bits:#010x})"),
        };
        let allowed = match self.allowed[word] {
            most if most >= 0.0 => format!(" within {most:.1e}"),
            _ => String::new(),
        };
        format!("expected {}{allowed}, device {}", show(self.expected[word]), show(found))
    }
}

impl Case {
    /// Whether a dispatch may write a buffer.
    #[must_use]
    pub fn writes(&self, buffer: usize) -> bool {
        self.dispatches.iter().flat_map(|dispatch| &dispatch.bindings).any(|b| b.buffer == buffer && b.writes)
    }

    /// The names of the kernels that it runs.
    #[must_use]
    pub fn kernels(&self) -> BTreeSet<String> {
        self.dispatches.iter().map(|dispatch| dispatch.kernel.clone()).collect()
    }

    /// Bytes of all buffers.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.buffers.iter().map(|part| 4 * part.before.len()).sum()
    }

    /// Groups of all dispatches.
    #[must_use]
    pub fn groups(&self) -> u64 {
        let groups = |dispatch: &Dispatch| dispatch.groups.iter().map(|&count| u64::from(count)).product::<u64>();
        self.dispatches.iter().map(groups).sum()
    }
}

/// Whether a word is as it should be.
#[must_use]
pub fn within(expected: u32, found: u32, allowed: f32) -> bool {
    if allowed == ANY || expected == found {
        return true;
    }
    let (p, q) = (f32::from_bits(expected), f32::from_bits(found));
    // NaN and infinity are never within a tolerance.
    allowed >= 0.0 && p.is_finite() && q.is_finite() && (f64::from(p) - f64::from(q)).abs() <= f64::from(allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_compared_by_what_is_allowed() {
        let near = (1f32.to_bits(), 1.001f32.to_bits());
        assert!(within(near.0, near.1, 0.01) && !within(near.0, near.1, 1e-4) && !within(near.0, near.1, BITS));
        assert!(within(near.0, near.1, ANY) && within(7, 7, BITS));
        assert!(!within(0, f32::NAN.to_bits(), 1e30) && !within(0, f32::INFINITY.to_bits(), f32::INFINITY));
        assert!(!within(0, (-0f32).to_bits(), BITS) && within(0, (-0f32).to_bits(), 0.0));
        let part = Part {
            name: "clusters".into(),
            words: vec![("center.0".into(), true), ("skip".into(), false)],
            first: 4,
            expected: vec![near.0, 1, near.0, 1],
            allowed: vec![0.01, BITS, 0.0, BITS],
            ..Part::default()
        };
        let found = [near.1, 2, near.1, 1];
        assert_eq!(part.wrong(&found).collect::<Vec<_>>(), [1, 2]);
        assert_eq!((part.place(1), part.place(2)), ("clusters[4].skip".into(), "clusters[5].center.0".into()));
        assert_eq!(part.values(1, 2), "expected 1 (0x00000001), device 2 (0x00000002)");
    }
}
