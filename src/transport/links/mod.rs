//! The method as Mertens et al. 2003 published it: links chosen by solid angles, one sample per link except near
//! triangles.
//!
//! The stages, in the order of a frame: `reach`, `mark_moved`, `mark_relit`, `mean_irradiance`, `refine`,
//! `form_factor`, `mark_stale`, `update_links`, `update_form_factors`, `sum_links`, `resum_links`, `push_links`,
//! `snapshot`. Those with `mark`, `update`, `resum` and `snapshot` in their names run where links are kept while the
//! shape changes.

pub mod form_factor;
pub mod mark_moved;
pub mod mark_relit;
pub mod mark_stale;
pub mod mean_irradiance;
pub mod push_links;
pub mod reach;
pub mod refine;
pub mod resum_links;
pub mod snapshot;
pub mod sum_links;
pub mod update_form_factors;
pub mod update_links;

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Size, Stage, State};

/// Defaults of a stage of transport by links.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage { module: "transport/links", carriers: &[Carrier::Links], ..super::stage(cpu, gpu) }
}

/// Room for the links of all chunks that are kept at once.
const LINKS: Size = Size::Grows(|state| state.chunk_parts() * state.data.object_params[0].link_capacity as usize);

/// Why stages that update kept links are skipped, if they are.
fn not_incremental(state: &State) -> Option<&'static str> {
    let why = "links are rebuilt when the shape changes; --mode incremental updates them";
    (!state.method.incremental).then_some(why)
}
