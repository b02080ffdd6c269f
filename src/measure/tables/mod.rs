//! Tables 3, 4 and 5 and figures 3, 4 and 5 of Mertens et al. 2003, measured again and shown with the paper's values.
//!
//! Absolute times of 2003 mean little today, so growth within one run and ratios are compared. The paper's columns
//! correspond to ours as follows: *on-the-fly* is a frame from scratch (`refit` to `push_links`); *render* is a new
//! light with kept links and form factors (`irradiance`, `mean_irradiance`, `sum_links`, `push_links`); *form factor*
//! is `transport.near = "exact"`; *point sampling* is `transport.near = "point-sampling"`. *Incremental* is a frame of
//! mode `incremental` after a bump moved on 1 % of the triangles; the paper does not say what changed in its frames
//! (`measure::modes` has other changes). Of its models only the horse is still available, so built-in shapes with about
//! as many triangles stand in. Subdivided models are butterfly subdivisions, as in the paper; the others have face
//! clusters.
//! The solid angles are not given: one value for both is fitted to the links per triangle of a table's first row, and
//! used for its other rows.

pub mod curves;
pub mod figures;
pub mod given;
mod measured;
mod models;
pub mod paper;
pub mod segments;
mod solve;

pub use measured::{table_3, table_4, table_5};
pub use models::mesh;

use crate::error::Result;
use crate::gpu::Device;
use crate::measure::table::Table;

/// Settings of the tables.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The device; `None` for the CPU.
    pub device: Option<&'a Device>,
    /// Mesh files to measure in addition to the built-in shapes.
    pub meshes: &'a [String],
    /// Faces at which errors are measured.
    pub samples: usize,
    /// Rows of the paper with more triangles than this are left out.
    pub most_faces: usize,
}

/// A table of ours beside the paper's.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// Its name, one word.
    pub name: String,
    /// Lines above the table: what is measured, and the settings.
    pub before: Vec<String>,
    /// The paper's columns, then ours.
    pub table: Table,
    /// Lines below the table: what follows from it.
    pub after: Vec<String>,
}

/// Receives a table that grows, after each row.
pub type Tell<'a> = &'a mut dyn FnMut(&Beside) -> Result<()>;

/// Measures one of the paper's tables.
pub type Measure = fn(&Bench<'_>, Tell<'_>) -> Result<Vec<Beside>>;

/// The tables, by the names that `--only` takes.
pub const TABLES: [(&str, Measure); 3] = [("table 3", table_3), ("table 4", table_4), ("table 5, figure 5", table_5)];
