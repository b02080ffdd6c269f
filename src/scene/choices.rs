//! What a scene may choose about its light transport.

use serde::Deserialize;

/// How faces are grouped into clusters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hierarchy {
    /// Neighbouring clusters are joined, pair by pair, the most compact first.
    #[default]
    FaceClusters,
    /// The box is split at the median centre of its longest axis.
    Median,
    /// The mesh is a coarse base; its triangles are cut in four, new vertices by the modified butterfly scheme.
    Butterfly,
    /// A coarse base is made for a closed mesh and cut in four, new vertices on the mesh.
    ShrinkWrap,
}

/// How clusters give light to receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Emitters with moments, chosen by what they contribute, to blocks of receivers.
    #[default]
    Blocks,
    /// Pairs of clusters, as published.
    Links,
}

/// What decides whether a cluster is taken as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Oracle {
    /// What taking it as one may change the radiosity by.
    Contribution,
    /// Its solid angle, as published.
    SolidAngle,
}

/// From where to where the dipole's distances are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Between the points on the surface.
    #[default]
    Radial,
    /// To sources displaced along the emitter's normal, as the paper's table 1 has it.
    Table1,
}

/// How a triangle too near for a few samples gives light to a receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Near {
    /// By the line integral over its edges.
    #[default]
    Exact,
    /// By uniform point samples, one for each disc of a mean free path, as the paper's table 5 compares with.
    PointSampling,
}

/// Where radiosity is computed for a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Receivers {
    /// Wherever they are fewer.
    #[default]
    Auto,
    /// At the triangles' centroids, blended between vertices.
    Faces,
    /// At the places that the pixels show.
    Pixels,
}
