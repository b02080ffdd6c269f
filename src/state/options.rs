//! How a scene is to be run.

use crate::error::{Input, Result};

/// How light gets from where it enters to where it leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum ShadingMethod {
    /// The hierarchical method of Mertens et al. 2003.
    #[default]
    Hierarchy,
    /// The irradiance octree of Jensen and Buhler 2002: on the host's cores, whatever the device.
    Octree,
    /// Every face to every face.
    Brute,
    /// Light walks through the object, photon by photon: the reference without approximations, with noise.
    Walk,
    /// The diffusion equation, solved on the object's own surface: nearer to the truth than the dipole.
    Diffusion,
    /// Diffusion in each object where it holds, the dipole by `hierarchy` in the others; `plan` says why.
    Auto,
    /// No transport: only single scattering in layers, opaque objects, and reflections.
    None,
    /// No transport: the curvature-dependent reflectance function of Kubo et al. 2010, at each pixel.
    Cdrf,
    /// No transport: Lambert's cosine, at each pixel.
    Lambert,
    /// In texture space: irradiance blurred by Gaussians (d'Eon et al. 2007).
    TextureBlur,
}

impl ShadingMethod {
    /// Whether no light is carried through the material: radiosity depends only on the light at the same point, or
    /// near it in the texture.
    #[must_use]
    pub fn is_local(self) -> bool {
        matches!(self, Self::Cdrf | Self::Lambert | Self::TextureBlur)
    }
}

/// What survives from frame to frame (section 5.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Mode {
    /// Everything from scratch in each frame.
    #[default]
    OnTheFly,
    /// Links made for the light of one frame: a frame in which nothing changes only sums over them again.
    #[cfg_attr(feature = "cli", value(skip))]
    Keep,
    /// Links are kept, and work for any light.
    ///
    /// When the light changes, light and radiosity are computed again, but lists are rebuilt only if
    /// `irradiance_ratio` changes.
    Render,
    /// Links are also kept while the shape changes: see `transport.budget`.
    ///
    /// Only those that touch an altered cluster are decided again. For scheme `links`; with blocks it acts as
    /// `Render`.
    Incremental,
}

impl Mode {
    /// This mode if it keeps links, else [`Self::Keep`].
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
    /// A picture, with layers of face data beside it.
    Layers,
    /// The radiosity of the faces.
    Radiosity,
}

/// How a scene is rendered: how light is carried, what is kept from frame to frame, and what for.
///
/// ```
/// use milkglass::{Mode, Options, ShadingMethod};
///
/// // Local shading by curvature; links of the hierarchical method, kept while the light moves.
/// let local = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
/// let relit = Options { mode: Mode::Render, ..Options::default() };
/// assert_ne!(local, relit);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The transport.
    pub transport: ShadingMethod,
    /// The mode.
    pub mode: Mode,
    /// The goal.
    pub goal: Goal,
    /// Whether an error estimate is requested for each receiver; only scheme `blocks` and diffusion have one.
    pub estimate: bool,
}

impl Options {
    /// These options for a picture with layers: one layer is the error estimate, and another shows the lengths of the
    /// lists, which must be kept for it.
    #[must_use]
    pub fn with_layers(self) -> Self {
        Self { goal: Goal::Layers, estimate: true, mode: self.mode.kept(), ..self }
    }

    /// Fails for local shading, which carries no light that `what` could report on.
    pub fn carries(&self, what: &str) -> Result<()> {
        if !self.transport.is_local() {
            return Ok(());
        }
        let fault = Input::new(format!("{what} needs a method that transports light")).key("--transport");
        Err(fault
            .found("cdrf, lambert or texture-blur")
            .expected("hierarchy, octree, brute, walk, diffusion or auto")
            .into())
    }
}
