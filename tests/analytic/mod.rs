//! The numerics against closed forms, independent quadrature, published figures, and their own invariants.

mod borders;
mod curvature;
mod edge_form;
mod form_factor;
mod fresnel;
mod hierarchy;
mod ladder;
mod laws;
mod materials;
mod method;
mod moments;
mod properties;
mod quadrature;
mod reflectance;
mod sphere;
mod stages;
mod table_one;
mod tables;
