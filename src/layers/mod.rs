//! Single scattering beneath a surface: in layers, by subsurface texture mapping (Francois et al. 2006), and in the
//! medium of an object.
//!
//! Errors of the paper are corrected to what it means: signs, clamps, normalised normals and dual texture axes.

pub mod beneath;
pub mod islands;
pub mod plane_fit;
pub mod relief;
pub mod single_scattering;
pub mod slab;
