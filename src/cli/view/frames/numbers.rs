//! Numbers about the frames: errors, times, lengths of lists.

use std::fmt::Write as _;

use milkglass::internals::layout::ListCounters;
use milkglass::scene::Scene;

use super::{Frames, Progress};
use crate::cli::view::drafts::{FACTORS, LEVELS};

impl Frames {
    /// The estimated error of the picture, r g b, once it is there.
    pub(in crate::cli::view) fn error(&self) -> Option<[f64; 3]> {
        self.check.error()
    }

    /// How long frames took, in words. Drafts before the first whole picture open sessions and compile kernels.
    pub(in crate::cli::view) fn times(&self) -> String {
        let (first, later) = self.drafted.split_at(self.first_drafts.unwrap_or(self.drafted.len()));
        let most = |times: &[f64]| times.iter().copied().fold(0.0, f64::max);
        let mut text = String::new();
        if !later.is_empty() {
            let mut sorted = later.to_vec();
            sorted.sort_by(f64::total_cmp);
            let _ = write!(
                text,
                "a draft took {:.0} ms (median), {:.0} ms at most; ",
                sorted[sorted.len() / 2],
                most(later)
            );
        }
        if !first.is_empty() {
            let _ = write!(text, "before the first whole picture a draft took {:.0} ms at most; ", most(first));
        }
        let _ = write!(text, "a part of a whole picture {:.0} ms at most", self.longest.as_secs_f64() * 1e3);
        text
    }

    /// Entries of the longest lists of links in the session that is shown, and how often frames of all sessions were
    /// repeated because a list did not fit.
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
