//! A frame as a list: what its entries are, and how long its parts took.

use std::fmt::{Display, Formatter};
use std::rc::Rc;
use std::time::{Duration, Instant};

use ash::vk;

use super::kernel::Kernel;

/// How long one labelled part of a frame took.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The label.
    pub name: String,
    /// Time on the device, milliseconds; not a number where the device has no timestamps.
    pub milliseconds: f64,
    /// When it began, milliseconds after the first part of its submission; not a number where the device has no
    /// timestamps.
    pub start: f64,
    /// When it began by the host's clock, and how far that may be off; none unless the device's clock is read: see
    /// [`super::LogicalDevice::align_clocks`].
    pub began: Option<(Instant, Duration)>,
    /// Its dispatches; 0 for what the host does.
    pub dispatches: usize,
    /// The barriers recorded before them.
    pub barriers: usize,
}

/// A part of a buffer. Handles may be given to a new buffer; the number never is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BoundRange {
    pub(super) buffer: vk::Buffer,
    pub(super) number: u64,
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// How many groups a dispatch has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Groups {
    /// This many in each dimension.
    Direct([u32; 3]),
    /// As many as three numbers in a buffer say.
    Counted { range: BoundRange },
}

/// A dispatch in the list.
#[derive(Clone)]
pub(super) struct Listed {
    pub(super) kernel: Rc<Kernel>,
    /// What each of its accesses is bound to.
    pub(super) ranges: Vec<BoundRange>,
    pub(super) push: Vec<u8>,
    pub(super) groups: Groups,
}

impl PartialEq for Listed {
    fn eq(&self, other: &Self) -> bool {
        Rc::ptr_eq(&self.kernel, &other.kernel)
            && (&self.ranges, &self.push, self.groups) == (&other.ranges, &other.push, other.groups)
    }
}

/// Which part of the work it is that a part of a frame does, for labels: words with numbers, `object 0, batch 2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place(pub [Option<(&'static str, usize)>; 3]);

impl Display for Place {
    fn fmt(&self, out: &mut Formatter<'_>) -> std::fmt::Result {
        let words = self.0.iter().flatten().map(|(word, number)| format!("{word} {number}"));
        out.write_str(&words.collect::<Vec<_>>().join(", "))
    }
}

/// An entry of the list.
#[derive(Clone, PartialEq)]
pub(super) enum Entry {
    /// A part of this name begins.
    Begin(String, Place),
    /// A dispatch.
    Dispatch(Listed),
    /// Bytes are copied from the first to the second, as many as that has.
    Copy([BoundRange; 2]),
    /// A part ends.
    End,
}
