//! Tables 3, 4 and 5 and figures 3, 4 and 5 of Mertens et al. 2003, measured again beside what the paper prints.
//!
//! Absolute times of 2003 mean nothing today: what is compared is how times grow within one run, and their ratios. The
//! paper's columns map to ours so: *on-the-fly* is a frame from scratch (`refit` to `push_links`), *render* is a new
//! light over kept links and form factors (`irradiance`, `mean_irradiance`, `sum_links`, `push_links`), *form factor*
//! is `transport.near = "exact"`, *point sampling* is `transport.near = "point-sampling"`. Its incremental mode is
//! compared with ours in `measure::modes`: what changed in its frames is not reported. Its models are lost but the
//! horse: shapes made here stand in, with as many triangles as their detail allows; all trees are face clusters. Its
//! solid angles are not given: one value for both is found from the links a triangle of a table's first row, and kept
//! for its other rows.

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

/// Where and on what the tables are measured.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The device; none is the CPU.
    pub device: Option<&'a Device>,
    /// Meshes from files, beside the shapes made here.
    pub meshes: &'a [String],
    /// Faces at which errors are measured.
    pub samples: usize,
    /// The paper's rows of more triangles are left out.
    pub most_faces: usize,
}

/// A piece of a table, as it is measured.
pub enum Told<'a> {
    /// A line of words.
    Words(&'a str),
    /// The name of a table that begins, one word, and its columns'.
    Columns(&'a str, &'a [&'a str]),
    /// One of its rows.
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

/// Told a table, piece by piece.
pub type Tell<'a> = &'a mut dyn FnMut(Told<'_>);

/// One table: reports its rows as they come.
pub type Table = fn(&Bench<'_>, Tell<'_>) -> Result<()>;

/// The tables that are measured, by the names that `--only` takes.
pub const TABLES: [(&str, Table); 3] = [("table 3", table_3), ("table 4", table_4), ("table 5, figure 5", table_5)];
