//! The frame: every stage in order, with the loops that they run in. Conformance, profile and plan follow this list;
//! a new stage adds a line here.

use crate::geometry::{deform, placement, refit, skin, widen};
use crate::layers::{plane_fit, relief, single_scattering};
use crate::lighting::{environment, irradiance, opaque_faces, shadow, texture_in};
use crate::shading::{
    bake_irradiance, blur, cdrf, cdrf_cells, cdrf_table, cdrf_values, curvature, curvature_sums, lambert, pack_normals,
    smooth_curvature, texture_blur,
};
use crate::state::{Granularity, Host, Scope, Stage, State, Step};
use crate::transport::blocks::{acceptance_radii, coarse_solve, gather, irradiance_ratio, link, pull, push};
use crate::transport::diffusion::{boundary_integrals, deposit, krylov_step, krylov_sum, near_layers};
use crate::transport::links::{
    form_factor, mark_moved, mark_relit, mark_stale, mean_irradiance, push_links, reach, refine, resum_links, snapshot,
    sum_links, update_form_factors, update_links,
};
use crate::transport::walk::{clearance, entry_sums, exit_radiosity, random_walk};
use crate::transport::{average, evaluate};
use crate::transport::{brute, octree};
use crate::view::{
    accumulate, backdrop, pixel_receivers, pixel_shadow, reflect, shade, shade_opaque, texture_out, tone, visibility,
};

/// The frame. A loop runs all of its stages for one object, chunk, group or batch before the next one, because where
/// lists are not kept they all share the same buffers.
pub static FRAME: &[Section] = &[
    section(
        "The shape of this frame",
        &[
            per_object(&[
                &skin::STAGE,
                &deform::STAGE,
                &refit::STAGE,
                &placement::STAGE,
                &curvature::STAGE,
                &curvature_sums::STAGE,
                &smooth_curvature::STAGE,
                &pack_normals::STAGE,
            ]),
            once(&[&widen::STAGE]),
        ],
    ),
    section("What each pixel sees", &[once(&[&visibility::STAGE])]),
    section(
        "The light that enters each face (equation 5)",
        &[once(&[&shadow::STAGE, &environment::STAGE]), per_object(&[&irradiance::STAGE, &texture_in::STAGE])],
    ),
    section("Transport by an irradiance octree", &[on_host(&octree::HOST)]),
    section(
        "Transport by links between clusters, as published",
        &[
            per_object(&[&reach::STAGE, &mark_moved::STAGE, &mark_relit::STAGE, &mean_irradiance::STAGE]),
            per_chunk(&[
                &refine::STAGE,
                &form_factor::STAGE,
                &mark_stale::STAGE,
                &update_links::STAGE,
                &update_form_factors::STAGE,
                &sum_links::STAGE,
                &resum_links::STAGE,
            ]),
            per_object(&[&push_links::STAGE, &snapshot::STAGE]),
        ],
    ),
    section(
        "Transport to blocks of receivers, to meet an error; lists for diffusion, too",
        &[
            per_group(&[&pull::STAGE, &coarse_solve::STAGE, &irradiance_ratio::STAGE, &acceptance_radii::STAGE]),
            per_object(&[&pixel_receivers::STAGE, &deposit::STAGE]),
            per_batch(&[&link::STAGE, &gather::STAGE, &near_layers::STAGE]),
            per_object(&[&push::STAGE]),
        ],
    ),
    section(
        "Transport by diffusion: the source term, then as many steps of GMRES as it takes",
        &[per_iteration(&[&boundary_integrals::STAGE, &krylov_step::STAGE]), per_object(&[&krylov_sum::STAGE])],
    ),
    section("Transport by brute force", &[per_object(&[&brute::STAGE])]),
    section(
        "Transport by a random walk",
        &[per_object(&[&entry_sums::STAGE, &clearance::STAGE, &random_walk::STAGE, &exit_radiosity::STAGE])],
    ),
    section(
        "Radiosity where pictures need it",
        &[per_object(&[&opaque_faces::STAGE, &average::STAGE, &plane_fit::STAGE])],
    ),
    section("Light that leaves towards the eye (equation 3)", &[once(&[&shade::STAGE])]),
    section(
        "Shading without transport",
        &[once(&[
            &cdrf_table::STAGE,
            &cdrf_cells::STAGE,
            &cdrf::STAGE,
            &lambert::STAGE,
            &bake_irradiance::STAGE,
            &blur::STAGE,
            &texture_blur::STAGE,
        ])],
    ),
    section(
        "Opaque objects, single scattering, textures, layers",
        &[once(&[
            &pixel_shadow::STAGE,
            &shade_opaque::STAGE,
            &single_scattering::STAGE,
            &texture_out::STAGE,
            &relief::STAGE,
        ])],
    ),
    section("Reflections, and what is behind the objects", &[once(&[&reflect::STAGE, &backdrop::STAGE])]),
    section("The picture", &[once(&[&accumulate::STAGE, &tone::STAGE])]),
];

/// Stages that are not part of a frame: they answer `milkglass eval`.
pub static QUERIES: &[&Stage] = &[&evaluate::STAGE, &cdrf_values::STAGE];

/// A part of the frame under a heading.
pub struct Section {
    /// The heading.
    pub title: &'static str,
    /// What runs, in order.
    pub parts: &'static [Part],
}

/// What runs in one go.
pub enum Part {
    /// These stages, in order, once for each object, chunk, group or batch, or once for the scene.
    Loop(Granularity, &'static [&'static Stage]),
    /// A step on the host.
    Host(&'static Host),
}

const fn section(title: &'static str, parts: &'static [Part]) -> Section {
    Section { title, parts }
}

/// A loop; does not compile if a stage has another granularity.
const fn each(granularity: Granularity, stages: &'static [&'static Stage]) -> Part {
    let mut k = 0;
    while k < stages.len() {
        assert!(stages[k].granularity as u8 == granularity as u8, "a stage runs in the loop of its own granularity");
        k += 1;
    }
    Part::Loop(granularity, stages)
}

const fn once(stages: &'static [&'static Stage]) -> Part {
    each(Granularity::Scene, stages)
}

const fn per_object(stages: &'static [&'static Stage]) -> Part {
    each(Granularity::Object, stages)
}

const fn per_chunk(stages: &'static [&'static Stage]) -> Part {
    each(Granularity::Chunk, stages)
}

const fn per_group(stages: &'static [&'static Stage]) -> Part {
    each(Granularity::Group, stages)
}

const fn per_iteration(stages: &'static [&'static Stage]) -> Part {
    each(Granularity::Iteration, stages)
}

const fn per_batch(stages: &'static [&'static Stage]) -> Part {
    each(Granularity::Batch, stages)
}

const fn on_host(host: &'static Host) -> Part {
    Part::Host(host)
}

/// Every part of the frame, in order.
pub fn parts() -> impl Iterator<Item = &'static Part> {
    FRAME.iter().flat_map(|section| section.parts)
}

/// Room for all stages; with more of them [`STAGES`] does not compile.
const MOST_STAGES: usize = 128;

/// Every stage in the order of the frame, then the queries; and their number.
static ALL: ([&Stage; MOST_STAGES], usize) = {
    let mut all = [QUERIES[0]; MOST_STAGES];
    let (mut count, mut s) = (0, 0);
    while s < FRAME.len() {
        let mut p = 0;
        while p < FRAME[s].parts.len() {
            if let Part::Loop(_, stages) = &FRAME[s].parts[p] {
                count = listed(&mut all, count, stages);
            }
            p += 1;
        }
        s += 1;
    }
    count = listed(&mut all, count, QUERIES);
    (all, count)
};

/// Adds these stages behind the first `count` ones; does not compile if one of them is incomplete.
const fn listed(all: &mut [&'static Stage], mut count: usize, stages: &[&'static Stage]) -> usize {
    let mut k = 0;
    while k < stages.len() {
        assert!(stages[k].is_complete(), "a stage declares its names, equation, writes and the tolerances' reason");
        all[count] = stages[k];
        (count, k) = (count + 1, k + 1);
    }
    count
}

/// Every stage in the order of the frame, then the queries.
pub static STAGES: &[&Stage] = ALL.0.split_at(ALL.1).0;

/// A stage by its name.
pub fn stage(name: &str) -> Option<&'static Stage> {
    STAGES.iter().copied().find(|stage| stage.name == name)
}

/// The stage that a kernel belongs to: `MODULE/STAGE` or `MODULE/STAGE/PART`.
pub fn owner(kernel: &str) -> Option<&'static Stage> {
    STAGES.iter().copied().find(|stage| stage.owns(kernel))
}

/// The steps of the stages for which `runs` is true, in the order of the frame; it is given an object's index for
/// stages that run object by object.
pub fn steps(state: &State, runs: impl Fn(&Stage, Option<usize>) -> bool) -> Vec<Step> {
    let mut steps = Vec::new();
    for part in parts() {
        let Part::Loop(granularity, stages) = part else { continue };
        if *granularity == Granularity::Scene {
            let run = stages.iter().filter(|stage| runs(stage, None));
            steps.extend(run.map(|&stage| Step { stage, at: Scope::SCENE }));
            continue;
        }
        for (object, part) in state.objects.iter().enumerate() {
            let serves = |stage: &&Stage| (stage.serves.object)(part, &state.method) && runs(stage, Some(object));
            let run: Vec<&'static Stage> = stages.iter().copied().filter(serves).collect();
            let (groups, chunks) = match granularity {
                Granularity::Scene => (0, 0),
                Granularity::Object => (1, 1),
                Granularity::Chunk => (1, part.schedule.chunks.len()),
                Granularity::Group => (part.groups.len(), 1),
                Granularity::Batch => (part.groups.len(), part.schedule.batches.len()),
                Granularity::Iteration => (part.groups.len().min(1), state.method.steps as usize + 1),
            };
            for (group, chunk) in (0..groups).flat_map(|group| (0..chunks).map(move |chunk| (group, chunk))) {
                let at = Scope { object, chunk, group };
                steps.extend(run.iter().map(|&stage| Step { stage, at }));
            }
        }
    }
    steps
}

/// How many of these steps precede the host step, in a frame whose transport runs on the host.
pub fn before_host(steps: &[Step]) -> usize {
    steps.iter().take_while(|step| precedes_transport(step.stage)).count()
}

/// Whether a stage comes before the transport of light through the material, whichever carrier does it.
pub fn precedes_transport(stage: &Stage) -> bool {
    let before = parts().take_while(|part| matches!(part, Part::Loop(..)));
    before.flat_map(Part::stages).any(|known| known.is(stage))
}

impl Part {
    /// Its stages; none for a host step.
    pub fn stages(&self) -> impl Iterator<Item = &'static Stage> + use<> {
        match self {
            Self::Loop(_, stages) => stages.iter().copied(),
            Self::Host(_) => [].iter().copied(),
        }
    }
}

#[cfg(test)]
mod tests;
