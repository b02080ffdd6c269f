//! What the hierarchy of [`crate::transport`] is measured against.
//!
//! The method as Mertens et al. 2003 published it (links chosen by solid angles, one sample a link): `mean`, `reach`,
//! `refine`, `form_factor`, `collect`, `spread`, and `alter`, `relit`, `revise`, `renew`, `recollect`, `keep` where links are
//! kept while the shape changes; every face to every face: `brute`; and an irradiance octree in native
//! code: [`octree`].

pub mod alter;
pub mod brute;
pub mod collect;
pub mod form_factor;
pub mod keep;
pub mod mean;
pub mod octree;
pub mod reach;
pub mod recollect;
pub mod refine;
pub mod relit;
pub mod renew;
pub mod revise;
pub mod spread;

use crate::state::State;

/// Why the stages that update kept links have no place in a frame that keeps none.
fn not_incremental(state: &State) -> Option<&'static str> {
    let why = "links are made anew when the shape changes; --mode incremental revises them";
    (!state.method.incremental).then_some(why)
}
