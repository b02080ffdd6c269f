//! The program run from the command line; one file per command or subject.

mod amber;
mod aov;
mod borders;
#[cfg(feature = "shaderc")]
mod compile;
mod conform;
mod dependent;
mod device_limits;
mod diffusion;
mod eval;
mod extremes;
mod failures;
mod first_use;
mod fit;
mod guide;
mod lights;
mod line;
mod lists;
mod long_work;
mod pareto;
mod paths;
mod probes;
mod profile;
mod profile_compare;
#[cfg(feature = "shaderc")]
mod replaced;
mod report;
mod repro;
mod results;
#[cfg(feature = "shaderc")]
mod sanitize;
mod stress;
mod studio;
mod textures;
mod unfinished;
mod validity;
mod vary;
mod walk;
