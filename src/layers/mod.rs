//! Layers beneath a surface: subsurface texture mapping (Francois et al. 2006), light that scatters once.
//!
//! Where the paper errs, this follows what it means: signs, clamps, normalised normals and dual texture axes.

pub mod beneath;
pub mod islands;
pub mod plane_fit;
pub mod relief;
pub mod slab;
