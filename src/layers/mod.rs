//! Layers beneath a surface: subsurface texture mapping (Francois et al. 2006), single scattering.
//!
//! Errors of the paper are corrected to what it means: signs, clamps, normalised normals and dual texture axes.

pub mod beneath;
pub mod islands;
pub mod plane_fit;
pub mod relief;
pub mod slab;
