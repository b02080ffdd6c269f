//! How local shading works (Kubo et al. 2010): how its function is evaluated, and what curvature is.

use serde::Deserialize;

/// Rows and columns of the table of the CDRF.
pub const CDRF_TABLE: u32 = 256;

/// Texels a side of what light is blurred over.
pub const BLUR_TEXTURE: u32 = 512;

/// How the curvature-dependent reflectance function is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cdrf {
    /// In closed form.
    #[default]
    Closed,
    /// From a table, linear between its entries.
    Table,
}

/// What the curvature kappa of the CDRF is, of principal curvatures k1 and k2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kappa {
    /// sqrt((k1^2 + k2^2) / 2).
    #[default]
    Rms,
    /// |k1 + k2| / 2.
    Mean,
}
