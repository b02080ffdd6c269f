//! Balls of a material by the dipole and by a random walk, sigma_0 fitted to either, and the plot of both (Kubo et al.
//! 2010, figure 6).

pub mod fit;
pub mod walk;
