//! What has changed since the last frame, by object and kind; from it each stage decides whether it runs again.

/// What has changed; changes add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// The shape, or there was no frame yet: everything may differ.
    pub everything: bool,
    /// Where the object lies in the scene. With it come other lights, and another view.
    pub place: bool,
    /// How light spreads in the material: coefficients of the dipole, sigma_0 and the like.
    pub material: bool,
    /// What the surface reflects and lets out: pictures only.
    pub surface: bool,
    /// The lights, or what of them enters.
    pub light: bool,
    /// The camera.
    pub view: bool,
    /// The picture is to be shown, in 8 bits a channel.
    pub tone: bool,
    /// No input changed; radiosity is summed again. Over kept lists only the sums rerun (`gather`, `push` and the
    /// like); where lists are not kept they are rebuilt.
    pub resum: bool,
    /// The lists must be rebuilt: too short, or made for another light. Together with `everything`: there are no kept
    /// links to update.
    pub relink: bool,
}

impl Change {
    const NOTHING: Self = Self {
        everything: false,
        place: false,
        material: false,
        surface: false,
        light: false,
        view: false,
        tone: false,
        resum: false,
        relink: false,
    };
    /// Everything that radiance depends on.
    pub const EVERYTHING: Self = Self { everything: true, ..Self::NOTHING };
    /// Where the object lies in the scene.
    pub const PLACE: Self = Self { place: true, ..Self::NOTHING };
    /// How light spreads in the material.
    pub const MATERIAL: Self = Self { material: true, ..Self::NOTHING };
    /// What the surface reflects and lets out.
    pub const SURFACE: Self = Self { surface: true, ..Self::NOTHING };
    /// The lights.
    pub const LIGHT: Self = Self { light: true, ..Self::NOTHING };
    /// The camera.
    pub const VIEW: Self = Self { view: true, ..Self::NOTHING };
    /// The picture is to be shown.
    pub const TONE: Self = Self { tone: true, ..Self::NOTHING };
    /// Lists are rebuilt, and summed over.
    pub const RELINK: Self = Self { relink: true, ..Self::NOTHING };
    /// No input changed; radiosity is summed again.
    pub const RESUM: Self = Self { resum: true, ..Self::NOTHING };

    /// Both changes.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            everything: self.everything || other.everything,
            place: self.place || other.place,
            material: self.material || other.material,
            surface: self.surface || other.surface,
            light: self.light || other.light,
            view: self.view || other.view,
            tone: self.tone || other.tone,
            resum: self.resum || other.resum,
            relink: self.relink || other.relink,
        }
    }
}

/// What has changed for all objects, and for single ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// For all objects.
    all: Change,
    /// For each object, in addition; objects beyond the end have none.
    own: Vec<Change>,
}

impl From<Change> for Changes {
    fn from(all: Change) -> Self {
        Self { all, own: Vec::new() }
    }
}

impl Changes {
    /// What has changed for an object.
    #[must_use]
    pub fn of(&self, object: usize) -> Change {
        self.all.and(self.own.get(object).copied().unwrap_or_default())
    }

    /// What has changed for any object.
    #[must_use]
    pub fn any(&self) -> Change {
        self.own.iter().fold(self.all, |sum, own| sum.and(*own))
    }

    /// Adds a change of all objects.
    pub fn add(&mut self, change: Change) {
        self.all = self.all.and(change);
    }

    /// Adds a change of one object.
    pub fn add_to(&mut self, object: usize, change: Change) {
        let length = self.own.len().max(object + 1);
        self.own.resize(length, Change::default());
        self.own[object] = self.own[object].and(change);
    }

    /// Both changes.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        self.add(other.all);
        other.own.iter().enumerate().for_each(|(object, change)| self.add_to(object, *change));
        self
    }

    /// Each change, mapped by `f`.
    #[must_use]
    pub fn map(&self, f: impl Fn(Change) -> Change) -> Self {
        Self { all: f(self.all), own: self.own.iter().map(|&change| f(change)).collect() }
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
    /// The shape has changed, or there was no frame yet: most stages run.
    #[must_use]
    pub fn shape(&self) -> bool {
        self.change.everything
    }

    /// The object lies elsewhere in the scene.
    #[must_use]
    pub fn placed(&self) -> bool {
        self.shape() || self.change.place
    }

    /// Light spreads differently in the material.
    #[must_use]
    pub fn material(&self) -> bool {
        self.shape() || self.change.material
    }

    /// The light that enters has changed.
    #[must_use]
    pub fn light(&self) -> bool {
        self.shape() || self.change.light
    }

    /// The light that enters has changed, or how it spreads.
    #[must_use]
    pub fn transport(&self) -> bool {
        self.light() || self.change.material
    }

    /// The camera has changed.
    #[must_use]
    pub fn view(&self) -> bool {
        self.shape() || self.change.view
    }

    /// Radiosity is summed again.
    #[must_use]
    pub fn sums(&self) -> bool {
        self.transport() || self.resums()
    }

    /// The picture differs.
    #[must_use]
    pub fn picture(&self) -> bool {
        self.sums() || self.view() || self.change.surface
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

    /// Form factors of kept links are computed again, of the same shape.
    #[must_use]
    pub fn renews_factors(&self) -> bool {
        !self.change.everything && (self.resums() || (self.change.material && !self.makes_links()))
    }

    /// Radiosity is summed over all links, not only over those that an update of kept links has touched.
    #[must_use]
    pub fn sums_all_links(&self) -> bool {
        !self.incremental || self.change.light || self.makes_links()
    }

    /// Links are built from scratch, with their form factors. The oracle of links does not depend on the material, but
    /// their form factors and the rules by which these are computed do.
    #[must_use]
    pub fn makes_links(&self) -> bool {
        match (self.incremental, self.keeps) {
            (true, _) => self.change.relink && (self.change.everything || self.change.material),
            (false, true) => self.material() || self.change.relink,
            (false, false) => self.sums(),
        }
    }
}
