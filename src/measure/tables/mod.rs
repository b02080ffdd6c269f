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
mod figures;
pub mod given;
mod models;
pub mod paper;
mod print;
pub mod segments;
mod solve;

pub use figures::{figure_3, figure_4, given};
pub use print::{table_3, table_4, table_5};

use std::fmt::{Display, Formatter};

use crate::error::Result;
use crate::gpu::Device;

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

/// A piece of a table, as it is reported.
pub enum Told<'a> {
    /// A line of text.
    Words(&'a str),
    /// Starts a table: its name, one word, and its column headings.
    Columns(&'a str, &'a [&'a str]),
    /// A row of the current table.
    Row(&'a [String]),
}

impl Display for Told<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Words(words) => f.write_str(words),
            Self::Columns(_, header) => header.iter().try_for_each(|cell| write!(f, "{cell:>12}")),
            Self::Row(cells) => cells.iter().try_for_each(|cell| write!(f, "{cell:>12}")),
        }
    }
}

/// Receives a table, piece by piece.
pub type Tell<'a> = &'a mut dyn FnMut(Told<'_>);

/// Measures one table and reports each row as it is done.
pub type Table = fn(&Bench<'_>, Tell<'_>) -> Result<()>;

/// The tables, by the names that `--only` takes.
pub const TABLES: [(&str, Table); 3] = [("table 3", table_3), ("table 4", table_4), ("table 5, figure 5", table_5)];
