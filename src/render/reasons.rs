//! Why a stage has no place in the frame of a scene.

use super::lights::lit;
use super::options::{Goal, Mode, Options, Transport};
use crate::state::{Local, Method, Object, Scheme, State};

/// Stages of the hierarchy with blocks.
const BLOCKS: [&str; 7] = ["pull", "level", "contrast", "radii", "link", "gather", "push"];
/// Stages of the hierarchy as published.
const LINKS: [&str; 12] = [
    "reach",
    "alter",
    "relit",
    "mean",
    "refine",
    "form_factor",
    "revise",
    "renew",
    "collect",
    "recollect",
    "spread",
    "keep",
];
/// Those of mode `incremental`.
const REVISION: [&str; 6] = ["alter", "relit", "revise", "renew", "recollect", "keep"];

/// Stages of local shading.
const LOCAL: [&str; 9] =
    ["curvature", "pack", "cdrf_table", "cdrf_cells", "cdrf", "lambert", "unwrap", "blur", "texture_blur"];

/// Why this stage has no place in the frame, if it has none.
pub(super) fn reason(name: &str, options: Options, method: Method, dark: bool) -> Option<String> {
    let scheme = method.scheme;
    let (blocks, links) = (BLOCKS.contains(&name), LINKS.contains(&name));
    let needs_light = blocks
        || links
        || matches!(
            name,
            "shadow" | "environment" | "irradiance" | "entry" | "points" | "opaque" | "average" | "brute"
        )
        || matches!(name, "reached" | "plain")
        || LOCAL.contains(&name)
        || matches!(name, "exit" | "plane_fit" | "relief" | "reflect");
    let pictorial = LOCAL.contains(&name)
        || matches!(name, "average" | "visibility" | "points" | "shade" | "exit" | "reflect" | "backdrop")
        || matches!(name, "plane_fit" | "relief" | "reached" | "plain");
    if name == "evaluate" || name == "cdrf_values" {
        return Some("answers `milkglass eval` only".into());
    }
    if pictorial && options.goal == Goal::Radiosity {
        return Some("no picture is asked for".into());
    }
    if needs_light && dark {
        return Some("no light shines: every radiosity is zero".into());
    }
    if options.transport.is_local() && (blocks || links || name == "brute") {
        return Some("no light is carried: what comes back depends on the place alone".into());
    }
    if !options.transport.is_local() && LOCAL.contains(&name) {
        return Some("light is carried; --transport cdrf, lambert or texture-blur does without".into());
    }
    match options.transport {
        Transport::Hierarchy if name == "brute" => Some("the hierarchy transports the light".into()),
        Transport::Hierarchy if links && scheme == Scheme::Blocks => Some("scheme blocks carries the light".into()),
        Transport::Hierarchy if blocks && scheme == Scheme::Links => Some("scheme links carries the light".into()),
        Transport::Octree if blocks || links || name == "brute" => {
            Some("the octree carries the light, in native code on the host".into())
        }
        Transport::None if blocks || links || name == "brute" => Some("no light is to be carried".into()),
        _ if name == "contrast" && !method.any_light => Some("lists are made for the light of their frame".into()),
        Transport::Hierarchy if REVISION.contains(&name) && !method.incremental => {
            Some("links are made anew when the shape changes; --mode incremental revises them".into())
        }
        Transport::Brute if blocks || links && name != "reach" => Some("brute force needs no clusters".into()),
        _ => None,
    }
}

/// Why local shading does without this stage, if it does.
pub(super) fn delocalized(name: &str, state: &State) -> Option<String> {
    let local = state.method.local?;
    let opaque = state.objects.iter().any(|object| object.opaque);
    let by_face = state.objects.iter().any(|object| object.opaque && object.lit_by_face());
    let alone = "light is looked at where the pixels are";
    match name {
        "irradiance" | "entry" | "average" if !by_face => Some(alone.into()),
        "shade" if !by_face && lit(state) && state.objects.iter().any(|object| !object.opaque) => Some(alone.into()),
        "shadow" if local.spares_itself() && state.objects.len() == 1 && !opaque => {
            Some("an object does not shadow itself in local shading, and there is no other".into())
        }
        "unwrap" | "blur" | "texture_blur" if local != Local::Blur => {
            Some("light is looked at where the pixels are, not over the texture coordinates".into())
        }
        "curvature" | "pack" | "cdrf" | "cdrf_table" | "cdrf_cells" | "lambert" if local == Local::Blur => {
            Some("light is blurred over the texture coordinates".into())
        }
        "curvature" | "cdrf" if local == Local::Lambert => Some("Lambert's cosine knows no curvature".into()),
        "cdrf_table" | "cdrf_cells" if local == Local::Lambert => Some("Lambert's cosine needs no table".into()),
        "cdrf_table" | "cdrf_cells" if local == Local::Closed => {
            Some("transport.cdrf is closed: nothing is looked up".into())
        }
        "lambert" if local != Local::Lambert => Some("the CDRF takes its place".into()),
        _ => None,
    }
}

/// Why this stage is not needed for these lights, this surface and this camera, if it is not.
pub(super) fn unlit(name: &str, state: &State) -> Option<String> {
    match name {
        "shadow" | "reached" if state.data.frame.iter().all(|frame| frame.shadow_words == 0) => {
            Some("no light casts shadows, and no environment asks what is hidden of it".into())
        }
        "environment" if state.data.sky.is_empty() => Some("no light is an environment".into()),
        "reflect" if state.data.frame.iter().all(|frame| frame.reflection == 0) => {
            Some("the material's surface reflects nothing".into())
        }
        "backdrop" if state.data.camera.iter().all(|camera| camera.environment == 0) => {
            Some("the background is a colour".into())
        }
        "backdrop" if state.data.sky.is_empty() => Some("the environment is black".into()),
        _ => None,
    }
}

/// Why this stage is not needed for these objects, if it is not.
pub(super) fn unpeopled(name: &str, state: &State) -> Option<String> {
    let any = |opaque: bool| state.objects.iter().any(|object| object.opaque == opaque);
    let carries = BLOCKS.contains(&name) || LINKS.contains(&name) || LOCAL.contains(&name) || name == "brute";
    match name {
        "deform" if state.data.deforms.is_empty() => Some("nothing deforms an object".into()),
        "opaque" | "reached" | "plain" if !any(true) => Some("no object is opaque".into()),
        "reached" | "plain" if !state.objects.iter().any(Object::plain) => {
            Some("opaque objects are lit by triangle".into())
        }
        "opaque" if !state.objects.iter().any(|object| object.opaque && object.lit_by_face()) => {
            Some("opaque objects are lit where the pixels show them".into())
        }
        "shadow" | "irradiance" | "entry" | "average" if !state.objects.iter().any(Object::lit_by_face) => {
            Some("every object is opaque, and lit where the pixels show it".into())
        }
        "points" => state.objects.iter().all(|object| !object.by_pixel).then(|| "the receivers are triangles".into()),
        "average" if state.objects.iter().all(|object| object.by_pixel || !object.lit_by_face()) => {
            Some("the receivers are what the pixels show".into())
        }
        _ if carries && !any(false) => Some("every object is opaque".into()),
        _ => None,
    }
}

/// Why no error estimate is carried along, if none is.
pub(super) fn unestimated(state: &State, options: Options) -> Option<&'static str> {
    match options.transport {
        _ if state.method.estimate => None,
        Transport::Octree => Some("the octree estimates nothing"),
        Transport::None => Some("no light is carried"),
        Transport::Cdrf | Transport::Lambert | Transport::TextureBlur => {
            Some("no light is carried whose error could be estimated")
        }
        Transport::Brute => Some("brute force takes every pair of faces by itself, and estimates nothing"),
        Transport::Hierarchy if state.method.scheme == Scheme::Links => Some("scheme links has none"),
        Transport::Hierarchy => Some("nobody reads it: `solve` that writes or verifies does, and `render --aov`"),
    }
}

/// Why links are not revised where mode `incremental` was asked for, if they are not.
pub(super) fn unkept(state: &State, options: Options) -> Option<&'static str> {
    match options.transport {
        _ if options.mode != Mode::Incremental => None,
        Transport::Hierarchy if state.method.scheme == Scheme::Links => None,
        Transport::Hierarchy => Some(
            "lists of blocks depend on how bright the whole object is, so that any change of shape may alter all of them: they are \
             kept as mode render keeps them; scheme links has incremental ones",
        ),
        _ => Some("there are no links"),
    }
}

/// What the mode keeps from frame to frame.
pub fn about_mode(state: &State, options: Options) -> String {
    let links = state.method.scheme == Scheme::Links;
    let budget = state.data.frame.iter().map(|frame| u64::from(frame.budget)).sum::<u64>();
    match options.mode {
        _ if options.transport != Transport::Hierarchy => "no links to keep".into(),
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
            "render: lists serve any light, and are kept until the shape changes".into()
        }
    }
}
