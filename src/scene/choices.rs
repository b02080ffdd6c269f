//! Enumerated settings of light transport.

use serde::Deserialize;

/// How faces are grouped into clusters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hierarchy {
    /// Adjacent clusters are merged pairwise, the most compact pair first.
    #[default]
    FaceClusters,
    /// Faces are split at the median centroid along the longest axis.
    Median,
    /// The mesh is a coarse base, subdivided 4-to-1 by the modified butterfly scheme.
    Butterfly,
    /// A coarse base is made for a closed mesh and subdivided 4-to-1, with new vertices on the mesh.
    ShrinkWrap,
}

/// How light is transported from clusters to receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// To blocks of receivers, from emitters with moments, which are selected by their contribution.
    #[default]
    Blocks,
    /// By links between pairs of clusters, as published.
    Links,
}

/// Criterion for treating a cluster as one emitter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Oracle {
    /// The change in radiosity that this approximation may cause.
    Contribution,
    /// The cluster's solid angle, as published.
    SolidAngle,
}

/// Which points the dipole's distances are measured between.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Between the points on the surface.
    #[default]
    Radial,
    /// From sources displaced along the emitter's normal, as in the paper's table 1.
    Table1,
}

/// How the form factor of a triangle too near for a few samples is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Near {
    /// As a line integral over its edges.
    #[default]
    Exact,
    /// By uniform point samples, one per disc with a radius of one mean free path, the method that the paper's table 5
    /// compares with.
    PointSampling,
}

/// Scheme `links`: how the form factor of a cluster too near for one sample is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClusterForm {
    /// Its triangles are projected onto the plane across its mean normal, and the polygon is integrated over its
    /// border, as published.
    #[default]
    Projected,
    /// By one sample at the cluster's midpoint, however near it is.
    Sample,
}

/// Where radiosity is computed for a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Receivers {
    /// At faces or pixels, whichever are fewer.
    #[default]
    Auto,
    /// At the triangles' centroids, interpolated between vertices.
    Faces,
    /// At the surface points that the pixels show.
    Pixels,
}
