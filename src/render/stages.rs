//! The table of stages. Conformance, profile, plan and the README go by it; adding a stage adds a line here.

use crate::baseline::{
    alter, brute, collect, form_factor, keep, mean, reach, recollect, refine, relit, renew, revise, spread,
};
use crate::geometry::{deform, refit};
use crate::layers::{plane_fit, relief};
use crate::light::{entry, environment, irradiance, opaque, shadow};
use crate::local::{blur, cdrf, cdrf_cells, cdrf_table, cdrf_values, curvature, lambert, pack, texture_blur, unwrap};
use crate::state::{Object, Place, Stage, State, Step, Unit};
use crate::transport::{average, contrast, evaluate, gather, level, link, pull, push, radii};
use crate::view::{backdrop, exit, plain, points, reached, reflect, shade, visibility};

/// Every stage, in the order of a frame; the last three are no part of one: `brute` takes the place of
/// `pull` to `push`, `evaluate` and `cdrf_values` answer `milkglass eval`.
pub static STAGES: &[&Stage] = &[
    &deform::STAGE,
    &refit::STAGE,
    &curvature::STAGE,
    &pack::STAGE,
    &visibility::STAGE,
    &shadow::STAGE,
    &environment::STAGE,
    &irradiance::STAGE,
    &entry::STAGE,
    &reach::STAGE,
    &alter::STAGE,
    &relit::STAGE,
    &mean::STAGE,
    &refine::STAGE,
    &form_factor::STAGE,
    &revise::STAGE,
    &renew::STAGE,
    &collect::STAGE,
    &recollect::STAGE,
    &spread::STAGE,
    &keep::STAGE,
    &pull::STAGE,
    &level::STAGE,
    &contrast::STAGE,
    &radii::STAGE,
    &points::STAGE,
    &link::STAGE,
    &gather::STAGE,
    &push::STAGE,
    &opaque::STAGE,
    &average::STAGE,
    &plane_fit::STAGE,
    &shade::STAGE,
    &cdrf_table::STAGE,
    &cdrf_cells::STAGE,
    &cdrf::STAGE,
    &lambert::STAGE,
    &unwrap::STAGE,
    &blur::STAGE,
    &texture_blur::STAGE,
    &reached::STAGE,
    &plain::STAGE,
    &exit::STAGE,
    &relief::STAGE,
    &reflect::STAGE,
    &backdrop::STAGE,
    &brute::STAGE,
    &evaluate::STAGE,
    &cdrf_values::STAGE,
];

/// A stage by its name.
pub fn stage(name: &str) -> Option<&'static Stage> {
    STAGES.iter().copied().find(|stage| stage.name == name)
}

/// Whether a stage has to do with an object: that light enters or not, whose receivers are pixels or triangles.
fn serves(stage: &Stage, object: &Object, local: bool) -> bool {
    match stage.name {
        "deform" => object.deforms > 0,
        "refit" => true,
        // Of others, light is looked at where the pixels are.
        "irradiance" | "entry" => object.lit_by_face() && (object.opaque || !local),
        "opaque" => object.opaque && object.lit_by_face(),
        "points" => object.by_pixel,
        "plane_fit" => object.layered,
        "average" => object.lit_by_face() && !object.by_pixel && (object.opaque || !local),
        _ => !object.opaque,
    }
}

/// The steps of these stages, in the table's order. Stages that work by objects, chunks, groups or batches take turns,
/// part after part, because parts may share their room.
pub fn steps(stages: &[&'static Stage], state: &State) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut rest = stages;
    while let Some(first) = rest.first() {
        let length = rest.iter().take_while(|stage| stage.unit == first.unit).count();
        let (run, after) = rest.split_at(length);
        if first.unit == Unit::Scene {
            steps.extend(run.iter().map(|&stage| Step { stage, at: Place::SCENE }));
        }
        for (object, part) in state.objects.iter().enumerate() {
            let (groups, chunks) = match first.unit {
                Unit::Scene => (0, 0),
                Unit::Object => (1, 1),
                Unit::Chunk => (1, part.schedule.chunks.len()),
                Unit::Group => (part.groups.len(), 1),
                Unit::Batch => (part.groups.len(), part.schedule.batches.len()),
            };
            for (group, chunk) in (0..groups).flat_map(|group| (0..chunks).map(move |chunk| (group, chunk))) {
                let at = Place { object, chunk, group };
                steps.extend(
                    run.iter()
                        .filter(|stage| serves(stage, part, state.method.local.is_some()))
                        .map(|&stage| Step { stage, at }),
                );
            }
        }
        rest = after;
    }
    steps
}
