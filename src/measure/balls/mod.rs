//! Balls of a material by a random walk, beside those by the dipole in [`crate::shading::balls`], and the plot of both
//! (Kubo et al. 2010, figure 6).

pub mod plot;
pub mod walk;
