//! The program from outside, one file a command or a subject. What fails, hangs or is given too little memory has programs
//! of its own beside this one.

#[path = "../shell/mod.rs"]
mod shell;

mod aov;
mod eval;
mod extremes;
mod fit;
mod lights;
mod line;
mod pareto;
mod profile;
mod stress;
mod textures;
mod validity;
