//! The plan of a frame: the stages that a scene needs, and why each other one is left out.

pub use crate::state::options::{Goal, Mode, Options, ShadingMethod};
pub use crate::state::{Change, Changes};

use super::frame::{STAGES, steps};
use super::skip_reasons::{reason, unestimated, unkept};
use crate::layout::{BUFFER_IDS, BufferId};
use crate::state::{Host, Stage, State, Step, Update};

/// The stages of a frame and those left out.
pub struct Plan {
    /// The stages that run, in order.
    pub stages: Vec<&'static Stage>,
    /// The stages that do not run, and other features that are left out, each with the reason.
    pub left_out: Vec<(&'static str, String)>,
    options: Options,
}

impl Plan {
    /// Makes the plan for this state and these options.
    pub fn new(state: &State, options: Options) -> Self {
        let mut plan = Self { stages: Vec::new(), left_out: Vec::new(), options };
        for &stage in STAGES {
            match reason(stage, state, options) {
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

    /// Adds something else that is left out, with the reason.
    #[must_use]
    pub fn without(mut self, what: (&'static str, String)) -> Self {
        self.left_out.push(what);
        self
    }

    /// The options that the plan was made for.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Whether the plan has this stage.
    pub fn has(&self, stage: &Stage) -> bool {
        self.stages.iter().any(|known| known.is(stage))
    }

    /// Whether a stage of the plan writes a buffer.
    pub fn writes(&self, id: BufferId) -> bool {
        self.stages.iter().any(|stage| stage.writes(id))
    }

    /// The steps of a frame after these changes.
    pub fn steps(&self, state: &State, changes: impl Into<Changes>) -> Vec<Step> {
        let changes = changes.into();
        let all = self.update(state, changes.any(), None);
        let each: Vec<Update> =
            (0..state.objects.len()).map(|object| self.update(state, changes.of(object), Some(object))).collect();
        let runs = |stage: &Stage, object: Option<usize>| (stage.runs)(object.map_or(&all, |object| &each[object]));
        // Objects may differ in what carries their light.
        let carries = |stage: &Stage, object: Option<usize>| {
            object.is_none() || stage.carriers.contains(&state.carrier(self.options.transport, object))
        };
        steps(state, |stage, object| self.has(stage) && carries(stage, object) && runs(stage, object))
    }

    /// What a frame after this change has to update, for an object or for all of them at once.
    pub(crate) fn update(&self, state: &State, change: Change, object: Option<usize>) -> Update {
        let linked = matches!(self.options.transport, ShadingMethod::Hierarchy | ShadingMethod::Auto);
        let links = self.options.mode != Mode::OnTheFly && linked;
        // The lists of diffusion depend on the shape and the material alone.
        let solves = object.map_or(state.method.solves(), |object| state.objects[object].solves());
        let keeps = links || solves;
        Update {
            change,
            keeps,
            any_light: keeps && (state.method.any_light || solves),
            incremental: state.method.incremental,
            by_pixel: state.objects.iter().any(|object| object.by_pixel),
        }
    }

    /// Whether a host step runs in a frame after this change.
    pub fn runs_on_host(&self, host: &Host, state: &State, changes: impl Into<Changes>) -> bool {
        let carries = state.carriers(self.options.transport).contains(&host.carrier);
        carries && self.writes(host.reads) && self.update(state, changes.into().any(), None).sums()
    }

    /// The buffers that are inputs.
    pub fn inputs() -> impl Iterator<Item = BufferId> {
        BUFFER_IDS.iter().copied().filter(|id| Self::is_input(*id))
    }

    /// Whether a buffer is an input: no stage writes it, or stages write it in some cases only (`blocks` where the
    /// receivers are pixels, `positions` of objects that deform).
    pub fn is_input(id: BufferId) -> bool {
        [BufferId::blocks, BufferId::positions].contains(&id) || !STAGES.iter().any(|stage| stage.writes(id))
    }
}

#[cfg(test)]
mod tests {
    use crate::pipeline::plan::*;
    use crate::state::Scheme;
    use crate::transport::octree::HOST;

    fn plan(scheme: Scheme, transport: ShadingMethod, mode: Mode) -> (State, Plan) {
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
        let (state, plan) = plan(scheme, ShadingMethod::Hierarchy, mode);
        plan.steps(&state, change).iter().map(|step| step.stage.name).collect()
    }

    #[test]
    fn a_resum_leaves_the_light_alone() {
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::RESUM), ["gather", "push"]);
        assert_eq!(names(Scheme::Blocks, Mode::OnTheFly, Change::RESUM), ["link", "gather", "push"]);
        assert_eq!(names(Scheme::Links, Mode::Render, Change::RESUM), ["sum_links", "push_links"]);
        let anew = ["refine", "form_factor", "sum_links", "push_links"];
        assert_eq!(names(Scheme::Links, Mode::OnTheFly, Change::RESUM), anew);
        let (state, plan) = plan(Scheme::Blocks, ShadingMethod::Brute, Mode::Render);
        assert_eq!(plan.steps(&state, Change::RESUM).iter().map(|s| s.stage.name).collect::<Vec<_>>(), ["brute"]);
    }

    #[test]
    fn a_new_light_leaves_the_shape_alone() {
        let blocks = ["irradiance", "pull", "coarse_solve", "acceptance_radii", "link", "gather", "push"];
        assert_eq!(names(Scheme::Blocks, Mode::OnTheFly, Change::LIGHT), blocks);
        assert_eq!(names(Scheme::Blocks, Mode::Keep, Change::LIGHT), blocks);
        let served = ["irradiance", "pull", "coarse_solve", "irradiance_ratio", "gather", "push"];
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::LIGHT), served);
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::RELINK), ["acceptance_radii", "link", "gather", "push"]);
        assert_eq!(
            names(Scheme::Links, Mode::Render, Change::LIGHT),
            ["irradiance", "mean_irradiance", "sum_links", "push_links"]
        );
        assert_eq!(names(Scheme::Blocks, Mode::Render, Change::VIEW), [""; 0]);
    }

    #[test]
    fn the_octree_takes_the_place_of_every_other_transport() {
        let (state, plan) = plan(Scheme::Links, ShadingMethod::Octree, Mode::OnTheFly);
        assert_eq!(plan.stages.iter().map(|stage| stage.name).collect::<Vec<_>>(), ["refit", "irradiance"]);
        assert!(plan.left_out.iter().any(|(stage, why)| *stage == "refine" && why.contains("on the host")));
        for (change, runs) in [(Change::LIGHT, true), (Change::RESUM, true), (Change::VIEW, false)] {
            assert_eq!(plan.runs_on_host(&HOST, &state, change), runs, "{change:?}");
        }
        assert_eq!(plan.steps(&state, Change::LIGHT).len(), 1);
    }
}
