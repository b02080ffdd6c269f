//! How a scene is to be run.

use crate::error::{Input, Result};

/// How light gets from where it enters to where it leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadingMethod {
    /// The hierarchical method of Mertens et al. 2003.
    #[default]
    Hierarchy,
    /// The irradiance octree of Jensen and Buhler 2002, on the host.
    Octree,
    /// Every face to every face.
    Brute,
    /// Not at all: what scatters once in layers, and what opaque objects give back.
    None,
    /// None: the curvature-dependent reflectance function of Kubo et al. 2010.
    Cdrf,
    /// None: Lambert's cosine.
    Lambert,
    /// Over the texture coordinates: irradiance blurred by Gaussians (d'Eon et al. 2007).
    TextureBlur,
}

impl ShadingMethod {
    /// Whether no light is carried through the material: what a surface gives back depends on what arrives at the very
    /// place, or near it in its texture.
    #[must_use]
    pub fn is_local(self) -> bool {
        matches!(self, Self::Cdrf | Self::Lambert | Self::TextureBlur)
    }
}

/// What survives from frame to frame (section 5.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Everything from scratch in each frame; links are scratch.
    #[default]
    OnTheFly,
    /// Links are made for the light of a frame, and kept: frames in which nothing changes sum them again only.
    Keep,
    /// Links serve any light, and are kept: a change of light runs `shadow`, `irradiance`, `pull`, `coarse_solve`,
    /// `irradiance_ratio`, `gather`, `push` and `average` only, as long as the ratio stays the same.
    Render,
    /// Links are kept while the shape changes, too: only those that touch an altered cluster are looked at again. Of
    /// scheme links; blocks have it as `Render`.
    Incremental,
}

impl Mode {
    /// The mode itself if it keeps links, else the one that keeps them as they are.
    #[must_use]
    pub fn kept(self) -> Self {
        if self == Self::OnTheFly { Self::Keep } else { self }
    }
}

/// What the frame is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Goal {
    /// A picture.
    #[default]
    Picture,
    /// A picture, and beside it what is known of the faces.
    Layers,
    /// The radiosity of the faces.
    Radiosity,
}

/// How a scene is to be run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The transport.
    pub transport: ShadingMethod,
    /// The mode.
    pub mode: Mode,
    /// The goal.
    pub goal: Goal,
    /// Whether an error estimate is wanted for each receiver; scheme blocks has one, the others do not.
    pub estimate: bool,
}

impl Options {
    /// For a picture with layers, of which one is the error estimate; another holds the lengths of the lists, so that
    /// they are kept.
    #[must_use]
    pub fn with_layers(self) -> Self {
        Self { goal: Goal::Layers, estimate: true, mode: self.mode.kept(), ..self }
    }

    /// Fails where no light is carried, that `what` could report on.
    pub fn carries(&self, what: &str) -> Result<()> {
        if !self.transport.is_local() {
            return Ok(());
        }
        let fault = Input::new(format!("{what} tells of light that is carried, and here none is")).key("--transport");
        Err(fault.found("cdrf, lambert or texture-blur").expected("hierarchy, octree or brute").into())
    }
}
