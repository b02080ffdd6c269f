//! What a scene needs: the stages of its frame, and each one left out with the reason.

pub use super::options::{Goal, Mode, Options, Transport};

use super::layers::unlayered;
use super::lights::lit;
use super::reasons::{delocalized, reason, unestimated, unkept, unlit, unpeopled};
use super::stages::{STAGES, steps};
use super::textures::untextured;
use crate::layout::{SLOTS, Slot};
use crate::state::{Stage, State, Step};

/// What has changed since the last frame; changes add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Everything, or there was no frame yet.
    pub everything: bool,
    /// The lights.
    pub light: bool,
    /// The camera.
    pub view: bool,
    /// Nothing, yet radiosity is summed again from what is known of the light: over kept links gather, push and
    /// average; where links are scratch they are made anew.
    pub resum: bool,
    /// The lists are of no use: too short, or kept for another light; with everything: no links are kept that could be revised.
    pub relink: bool,
}

impl Change {
    /// Everything.
    pub const EVERYTHING: Self = Self { everything: true, light: false, view: false, resum: false, relink: false };
    /// The lights.
    pub const LIGHT: Self = Self { everything: false, light: true, view: false, resum: false, relink: false };
    /// The camera.
    pub const VIEW: Self = Self { everything: false, light: false, view: true, resum: false, relink: false };
    /// Lists are made anew, and summed over.
    pub const RELINK: Self = Self { everything: false, light: false, view: false, resum: false, relink: true };
    /// Nothing, yet radiosity is summed again.
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

/// The stages of a frame and those left out.
pub struct Plan {
    /// The stages that run, in order.
    pub stages: Vec<&'static Stage>,
    /// The stages that do not, and what else is left out, each with the reason.
    pub left_out: Vec<(&'static str, String)>,
    options: Options,
}

impl Plan {
    /// Decides for this state and these options.
    pub fn new(state: &State, options: Options) -> Self {
        let mut plan = Self { stages: Vec::new(), left_out: Vec::new(), options };
        let dark = !lit(state);
        for &stage in STAGES {
            let why = reason(stage.name, options, state.method, dark);
            let why = why
                .or_else(|| delocalized(stage.name, state))
                .or_else(|| unlit(stage.name, state))
                .or_else(|| untextured(stage.name, state))
                .or_else(|| unlayered(stage.name, state));
            match why.or_else(|| unpeopled(stage.name, state)) {
                None => plan.stages.push(stage),
                Some(why) => plan.left_out.push((stage.name, why)),
            }
        }
        if let Some(why) = unestimated(state, options) {
            plan.left_out.push(("error estimate", why.into()));
        }
        if let Some(why) = unkept(state, options) {
            plan.left_out.push(("incremental links", why.into()));
        }
        plan
    }

    /// With something else that is left out, and the reason.
    #[must_use]
    pub fn without(mut self, what: (&'static str, String)) -> Self {
        self.left_out.push(what);
        self
    }

    /// The options it was made for.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Whether a stage of it writes a buffer.
    pub fn writes(&self, slot: Slot) -> bool {
        self.stages.iter().any(|stage| stage.writes.iter().any(|(written, _, _)| *written == slot))
    }

    /// The steps of a frame after this change.
    pub fn steps(&self, state: &State, change: Change) -> Vec<Step> {
        let kept = self.options.mode != Mode::OnTheFly && self.options.transport == Transport::Hierarchy;
        let any_light = kept && state.method.any_light;
        let resum = change.resum || change.relink;
        let (incremental, revises) = (state.method.incremental, change.everything && !change.relink);
        // Sums over all kept links, or over those that something has become of.
        let sums_all = !incremental || change.light || (change.everything && change.relink);
        let pixels = state.objects.iter().any(|object| object.by_pixel);
        let runs = |stage: &&'static Stage| match stage.name {
            "refine" | "form_factor" if incremental => change.everything && change.relink,
            "alter" | "revise" => revises,
            "relit" => revises && !sums_all,
            "collect" if !sums_all => false,
            "recollect" => !sums_all && (change.everything || resum),
            "renew" => revises || (resum && !change.everything),
            _ if change.everything => true,
            "keep" => false,
            "deform" | "refit" | "plane_fit" | "curvature" | "pack" | "cdrf_table" | "cdrf_cells" => false,
            "visibility" | "points" => change.view,
            "link" | "gather" | "push" if pixels && change.view => true,
            "shade" | "cdrf" | "lambert" | "texture_blur" | "reached" | "plain" | "exit" | "relief" | "reflect"
            | "backdrop" => change.view || change.light || resum,
            name if kept && builds_links(name) => change.relink,
            // Lists that are made anew anyway, for other pixels, are made for the light of now.
            "radii" if any_light && pixels && change.view && change.light => true,
            "radii" | "link" if any_light => change.relink,
            // Else the lists of blocks depend on the light.
            "link" if kept => change.light || change.relink,
            name => change.light || (resum && sums(name)),
        };
        let stages: Vec<_> = self.stages.iter().copied().filter(runs).collect();
        steps(&stages, state)
    }

    /// Whether the octree takes its turn in a frame after this change.
    pub fn octree(&self, change: Change) -> bool {
        let sees = self.stages.iter().any(|stage| stage.name == "irradiance");
        let summed = change.everything || change.light || change.resum;
        self.options.transport == Transport::Octree && sees && summed
    }

    /// Buffers that are inputs: no stage writes them, or not always.
    pub fn inputs() -> impl Iterator<Item = Slot> {
        // Blocks are made anew only where they are of pixels, positions only where something deforms the object.
        let sent = [Slot::blocks, Slot::positions];
        let made = |slot: &Slot| STAGES.iter().any(|s| s.writes.iter().any(|(w, _, _)| w == slot));
        SLOTS.iter().copied().filter(move |slot| sent.contains(slot) || !made(slot))
    }
}

/// Stages that a change of light can leave alone where links are kept.
fn builds_links(name: &str) -> bool {
    matches!(name, "reach" | "refine" | "form_factor")
}

/// Whether a stage comes before the light is carried through the material, whatever carries it.
pub fn before_transport(name: &str) -> bool {
    matches!(name, "deform" | "refit" | "visibility" | "shadow" | "environment" | "irradiance" | "entry")
}

/// Whether a stage lies between known irradiance, with its moments and distances, and radiosity.
fn sums(name: &str) -> bool {
    matches!(
        name,
        "link" | "gather" | "push" | "refine" | "form_factor" | "collect" | "spread" | "opaque" | "average" | "brute"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Scheme;

    fn plan(scheme: Scheme, transport: Transport, mode: Mode) -> (State, Plan) {
        let mut state = State::default();
        state.method.scheme = scheme;
        state.method.any_light = scheme == Scheme::Blocks && mode == Mode::Render;
        let mut object = crate::state::Object::default();
        object.schedule.chunks.push(crate::state::Chunk::default());
        object.schedule.batches.push(0..1);
        object.groups.push(crate::state::Group { channels: 7, lead: 0 });
        state.objects.push(object);
        state.data.lights.push(crate::layout::Light { color: [1.0; 3], ..Default::default() });
        let plan = Plan::new(&state, Options { transport, mode, goal: Goal::Radiosity, ..Options::default() });
        (state, plan)
    }

    fn names(scheme: Scheme, mode: Mode, change: Change) -> Vec<&'static str> {
        let (state, plan) = plan(scheme, Transport::Hierarchy, mode);
        plan.steps(&state, change).iter().map(|step| step.stage.name).collect()
    }

    #[test]
    fn a_resum_leaves_the_light_alone() {
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::RESUM), ["gather", "push"]);
        assert_eq!(names(Scheme::Blocks, Mode::OnTheFly, Change::RESUM), ["link", "gather", "push"]);
        assert_eq!(names(Scheme::Links, Mode::Render, Change::RESUM), ["collect", "spread"]);
        let anew = ["refine", "form_factor", "collect", "spread"];
        assert_eq!(names(Scheme::Links, Mode::OnTheFly, Change::RESUM), anew);
        let (state, plan) = plan(Scheme::Blocks, Transport::Brute, Mode::Render);
        assert_eq!(plan.steps(&state, Change::RESUM).iter().map(|s| s.stage.name).collect::<Vec<_>>(), ["brute"]);
    }

    #[test]
    fn a_new_light_leaves_the_shape_alone() {
        let blocks = ["irradiance", "pull", "level", "radii", "link", "gather", "push"];
        assert_eq!(names(Scheme::Blocks, Mode::OnTheFly, Change::LIGHT), blocks);
        assert_eq!(names(Scheme::Blocks, Mode::Keep, Change::LIGHT), blocks);
        let served = ["irradiance", "pull", "level", "contrast", "gather", "push"];
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::LIGHT), served);
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::RELINK), ["radii", "link", "gather", "push"]);
        assert_eq!(names(Scheme::Links, Mode::Render, Change::LIGHT), ["irradiance", "mean", "collect", "spread"]);
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::VIEW), [""; 0]);
    }

    #[test]
    fn the_octree_takes_the_place_of_every_other_transport() {
        let (state, plan) = plan(Scheme::Links, Transport::Octree, Mode::OnTheFly);
        assert_eq!(plan.stages.iter().map(|stage| stage.name).collect::<Vec<_>>(), ["refit", "irradiance"]);
        assert!(plan.left_out.iter().any(|(stage, why)| *stage == "refine" && why.contains("on the host")));
        for (change, runs) in [(Change::LIGHT, true), (Change::RESUM, true), (Change::VIEW, false)] {
            assert_eq!(plan.octree(change), runs, "{change:?}");
        }
        assert_eq!(plan.steps(&state, Change::LIGHT).len(), 1);
    }
}
