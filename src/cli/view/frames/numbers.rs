//! What the frames say of themselves in numbers.

use milkglass::internals::layout::ListCounters;
use milkglass::scene::Scene;

use super::{Frames, Progress};
use crate::cli::view::drafts::{FACTORS, LEVELS};

impl Frames {
    /// The estimated error of the picture, r g b, once it is there.
    pub(in crate::cli::view) fn error(&self) -> Option<[f64; 3]> {
        self.check.error()
    }

    /// How long drafts took, ms: the median and the most; and the parts of whole pictures, the most. None without a
    /// draft.
    pub(in crate::cli::view) fn times(&self) -> Option<[f64; 3]> {
        let mut sorted = self.drafted.clone();
        sorted.sort_by(f64::total_cmp);
        Some([*sorted.get(sorted.len() / 2)?, *sorted.last()?, self.longest.as_secs_f64() * 1e3])
    }

    /// Entries of the longest lists of links in the session that is shown, and how often frames of all were repeated
    /// because a list did not fit.
    pub(in crate::cli::view) fn counts(&self) -> [u64; 2] {
        let [transported, local] = &self.drafts;
        let draft = if LEVELS[self.policy.level].transport { transported } else { local };
        let shown = draft.as_ref().filter(|_| matches!(self.progress, Progress::Draft(_))).unwrap_or(&self.full);
        let longest = |counters: &ListCounters| counters.required_links.max(counters.required_entries);
        let links = shown.state().data.counters.iter().map(|counters| u64::from(longest(counters))).sum();
        let sessions = self.drafts.iter().flatten().chain([&self.full]);
        [links, sessions.map(|session| session.retries() as u64).sum()]
    }

    /// Width and height of a draft of the picture of a scene, in pixels.
    pub(in crate::cli::view) fn draft_size(&self, scene: &Scene) -> [u32; 2] {
        scene.camera.size.map(|side| side.div_ceil(FACTORS[self.policy.coarseness]))
    }
}
