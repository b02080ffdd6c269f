//! What has changed since the last frame; from it each stage decides whether it runs again.

/// What has changed since the last frame; changes add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Everything, or there was no frame yet.
    pub everything: bool,
    /// The lights.
    pub light: bool,
    /// The camera.
    pub view: bool,
    /// No input changed; radiosity is summed again. Over kept lists only the sums rerun (`gather`, `push` and the
    /// like); where lists are not kept they are rebuilt.
    pub resum: bool,
    /// The lists must be rebuilt: too short, or made for another light. Together with `everything`: there are no kept
    /// links to update.
    pub relink: bool,
}

impl Change {
    /// Everything.
    pub const EVERYTHING: Self = Self { everything: true, light: false, view: false, resum: false, relink: false };
    /// The lights.
    pub const LIGHT: Self = Self { everything: false, light: true, view: false, resum: false, relink: false };
    /// The camera.
    pub const VIEW: Self = Self { everything: false, light: false, view: true, resum: false, relink: false };
    /// Lists are rebuilt, and summed over.
    pub const RELINK: Self = Self { everything: false, light: false, view: false, resum: false, relink: true };
    /// No input changed; radiosity is summed again.
    pub const RESUM: Self = Self { everything: false, light: false, view: false, resum: true, relink: false };

    /// Both changes.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            everything: self.everything || other.everything,
            light: self.light || other.light,
            view: self.view || other.view,
            resum: self.resum || other.resum,
            relink: self.relink || other.relink,
        }
    }
}

/// A frame that follows another one: what has changed, and what is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// What has changed.
    pub change: Change,
    /// Whether links or lists are kept from frame to frame.
    pub keeps: bool,
    /// Whether kept lists serve any light.
    pub any_light: bool,
    /// Whether kept links are updated where the shape changes.
    pub incremental: bool,
    /// Whether receivers are the points that pixels show, so that a new view has new receivers.
    pub by_pixel: bool,
}

impl Update {
    /// The shape or the material has changed, or there was no frame yet: most stages run.
    #[must_use]
    pub fn shape(&self) -> bool {
        self.change.everything
    }

    /// The lights have changed.
    #[must_use]
    pub fn light(&self) -> bool {
        self.shape() || self.change.light
    }

    /// The camera has changed.
    #[must_use]
    pub fn view(&self) -> bool {
        self.shape() || self.change.view
    }

    /// Radiosity is summed again.
    #[must_use]
    pub fn sums(&self) -> bool {
        self.light() || self.resums()
    }

    /// The picture differs.
    #[must_use]
    pub fn picture(&self) -> bool {
        self.sums() || self.view()
    }

    /// Pixels show other receivers, or radiosity is summed again.
    #[must_use]
    pub fn sums_receivers(&self) -> bool {
        self.sums() || self.other_receivers()
    }

    /// Pixels show other receivers.
    #[must_use]
    pub fn other_receivers(&self) -> bool {
        self.by_pixel && self.change.view
    }

    /// Radiosity is summed again though the lights are the same.
    #[must_use]
    pub fn resums(&self) -> bool {
        self.change.resum || self.change.relink
    }

    /// Kept links are updated for a new shape.
    #[must_use]
    pub fn updates_links(&self) -> bool {
        self.incremental && self.change.everything && !self.change.relink
    }

    /// Radiosity is summed over all links, not only over those that an update of kept links has touched.
    #[must_use]
    pub fn sums_all_links(&self) -> bool {
        !self.incremental || self.change.light || (self.change.everything && self.change.relink)
    }

    /// Links are built from scratch.
    #[must_use]
    pub fn makes_links(&self) -> bool {
        match (self.incremental, self.keeps) {
            (true, _) => self.change.everything && self.change.relink,
            (false, true) => self.shape() || self.change.relink,
            (false, false) => self.sums(),
        }
    }
}
