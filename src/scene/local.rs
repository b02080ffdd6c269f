//! Settings of local shading (Kubo et al. 2010): how the CDRF is evaluated, and which curvature it takes.

use serde::Deserialize;

/// Default number of rows and columns of the CDRF table.
pub const CDRF_TABLE: u32 = 256;

/// Default side of the texture that irradiance is blurred in, texels.
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

/// The curvature kappa of the CDRF as a function of the principal curvatures k1 and k2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kappa {
    /// sqrt((k1^2 + k2^2) / 2).
    #[default]
    Rms,
    /// |k1 + k2| / 2.
    Mean,
}
