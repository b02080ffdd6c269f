//! Why a frame does without a stage, or without another feature.

use super::frame::QUERIES;
use crate::state::options::{Goal, Mode, Options, ShadingMethod};
use crate::state::{Carrier, Need, Scheme, Stage, State};

/// Why this stage has no place in the frame, if it has none.
pub(super) fn reason(stage: &Stage, state: &State, options: Options) -> Option<String> {
    if QUERIES.iter().any(|query| query.is(stage)) {
        return Some("answers `milkglass eval` only".into());
    }
    let lacks = |need: &Need| match need {
        Need::Picture => (options.goal == Goal::Radiosity).then_some("no picture is asked for"),
        Need::Rays => {
            let shadows = state.lit() && state.data.object_params.iter().any(|params| params.shadow_words > 0);
            (options.goal == Goal::Radiosity && !shadows)
                .then_some("no picture is asked for, and no light casts shadows")
        }
        Need::Light => (!state.lit()).then_some("no light shines: every radiosity is zero"),
    };
    if let Some(why) = stage.needs.iter().find_map(lacks) {
        return Some(why.into());
    }
    let carriers = state.carriers(options.transport);
    if !carriers.iter().any(|carrier| stage.carriers.contains(carrier)) {
        let join = |words: fn(&Carrier) -> &'static str, list: &[Carrier]| {
            list.iter().map(words).collect::<Vec<_>>().join(" and ")
        };
        let [instead, needed] =
            [join(|carrier| carrier.instead(), &carriers), join(|carrier| carrier.name(), stage.carriers)];
        return Some(format!("{instead}; part of {needed}"));
    }
    let nobody = || !state.objects.iter().any(|object| (stage.serves.object)(object, &state.method));
    (stage.skip)(state).or_else(|| nobody().then_some(stage.serves.none)).map(String::from)
}

/// Why there is no error estimate, if there is none.
pub(crate) fn unestimated(state: &State, options: Options) -> Option<&'static str> {
    match options.transport {
        _ if state.method.estimate => None,
        ShadingMethod::Octree => Some("the octree estimates nothing"),
        ShadingMethod::None => Some("no light is carried"),
        ShadingMethod::Cdrf | ShadingMethod::Lambert | ShadingMethod::TextureBlur => {
            Some("no light is carried whose error could be estimated")
        }
        ShadingMethod::Brute => Some("brute force takes every pair of faces by itself, and estimates nothing"),
        ShadingMethod::Walk => Some("a walk has a standard error instead"),
        ShadingMethod::Hierarchy if state.method.scheme == Scheme::Links => Some("scheme links has none"),
        ShadingMethod::Hierarchy | ShadingMethod::Diffusion | ShadingMethod::Auto => {
            Some("not requested; use `solve -o`, `--verify` or `render --aov`")
        }
    }
}

/// Why links are not updated although mode `incremental` is requested, if they are not.
pub(crate) fn unkept(state: &State, options: Options) -> Option<&'static str> {
    match options.transport {
        _ if options.mode != Mode::Incremental => None,
        ShadingMethod::Hierarchy if state.method.scheme == Scheme::Links => None,
        ShadingMethod::Hierarchy | ShadingMethod::Auto => Some(
            "lists of blocks depend on how bright the whole object is, so that any change of shape may alter all of them: they are \
             kept as mode render keeps them; scheme links has incremental ones",
        ),
        _ => Some("there are no links"),
    }
}

/// Describes what the mode keeps from frame to frame.
pub fn about_mode(state: &State, options: Options) -> String {
    let links = state.method.scheme == Scheme::Links;
    let budget = state.data.object_params.iter().map(|params| u64::from(params.budget)).sum::<u64>();
    match options.mode {
        Mode::Render | Mode::Incremental if state.method.solves() => {
            "render: lists are kept until the shape changes, and each solution starts from the last one".into()
        }
        _ if state.method.solves() => "on-the-fly: lists of diffusion are kept until the shape changes".into(),
        _ if !matches!(options.transport, ShadingMethod::Hierarchy | ShadingMethod::Auto) => "no links to keep".into(),
        Mode::OnTheFly => "on-the-fly: links are made for each frame".into(),
        Mode::Keep => "keep: links are kept until something changes".into(),
        Mode::Render if links => "render: links and form factors are kept until the shape changes".into(),
        Mode::Incremental if links && budget >= u64::from(u32::MAX) => {
            "incremental: links are kept, and revised where the shape changes; no budget".into()
        }
        Mode::Incremental if links => format!(
            "incremental: links are kept, and revised where the shape changes; at most {budget} form factors a frame once all \
             links are made"
        ),
        Mode::Render | Mode::Incremental => {
            "render: lists hold for any light, and are kept until the shape changes".into()
        }
    }
}
