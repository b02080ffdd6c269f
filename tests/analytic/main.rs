//! The CPU numerics against closed forms, independent quadrature, and published figures.

mod edge_form;
mod fresnel;
mod hierarchy;
mod ladder;
mod materials;
mod quadrature;
mod reflectance;
mod seeded;
mod sphere;
mod table_one;
