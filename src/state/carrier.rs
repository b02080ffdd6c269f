//! [`Carrier`]: what carries the light in an object.

use super::{Scheme, State};
use crate::state::options::ShadingMethod;

/// What carries light from where it enters to where it leaves: a transport and, for the hierarchy, its scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// The hierarchy, with blocks of receivers that share their lists.
    Blocks,
    /// The hierarchy as published, with links between clusters.
    Links,
    /// The irradiance octree.
    Octree,
    /// Brute force: every face to every face.
    Brute,
    /// A random walk through the object.
    Walk,
    /// Diffusion within the object's own surface.
    Diffusion,
    /// No light is carried.
    Nothing,
    /// The curvature-dependent reflectance function takes the place of transport.
    Cdrf,
    /// Lambert's cosine takes the place of transport.
    Lambert,
    /// Irradiance blurred over the texture coordinates takes the place of transport.
    TextureBlur,
}

impl Carrier {
    /// All carriers.
    pub const ALL: &'static [Self] = &[
        Self::Blocks,
        Self::Links,
        Self::Octree,
        Self::Brute,
        Self::Walk,
        Self::Diffusion,
        Self::Nothing,
        Self::Cdrf,
        Self::Lambert,
        Self::TextureBlur,
    ];

    /// The carrier for a transport and a scheme, in an object for which a system of equations is solved or not.
    #[must_use]
    pub fn new(transport: ShadingMethod, scheme: Scheme, solves: bool) -> Self {
        match (transport, scheme) {
            (ShadingMethod::Auto, _) if solves => Self::Diffusion,
            (ShadingMethod::Auto, _) | (ShadingMethod::Hierarchy, Scheme::Blocks) => Self::Blocks,
            (ShadingMethod::Hierarchy, Scheme::Links) => Self::Links,
            (ShadingMethod::Octree, _) => Self::Octree,
            (ShadingMethod::Brute, _) => Self::Brute,
            (ShadingMethod::Walk, _) => Self::Walk,
            (ShadingMethod::Diffusion, _) => Self::Diffusion,
            (ShadingMethod::None, _) => Self::Nothing,
            (ShadingMethod::Cdrf, _) => Self::Cdrf,
            (ShadingMethod::Lambert, _) => Self::Lambert,
            (ShadingMethod::TextureBlur, _) => Self::TextureBlur,
        }
    }

    /// The option that selects it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Blocks => "scheme blocks",
            Self::Links => "scheme links",
            Self::Octree => "--transport octree",
            Self::Brute => "--transport brute",
            Self::Walk => "--transport walk",
            Self::Diffusion => "--transport diffusion",
            Self::Nothing => "--transport none",
            Self::Cdrf => "--transport cdrf",
            Self::Lambert => "--transport lambert",
            Self::TextureBlur => "--transport texture-blur",
        }
    }

    /// Why the stages of other carriers have no place in the frame.
    #[must_use]
    pub fn instead(self) -> &'static str {
        match self {
            Self::Blocks => "scheme blocks carries the light",
            Self::Links => "scheme links carries the light",
            Self::Octree => "the octree carries the light, in native code on the host",
            Self::Brute => "brute force carries the light, and needs no clusters",
            Self::Walk => "photons carry the light, and need no clusters",
            Self::Diffusion => "diffusion carries the light, solved on the object's own surface",
            Self::Nothing => "no light is carried",
            Self::Cdrf => "no light is carried: the CDRF shades each place by itself",
            Self::Lambert => "no light is carried: Lambert's cosine shades each place by itself",
            Self::TextureBlur => "no light is carried: it is blurred over the texture coordinates",
        }
    }
}

impl State {
    /// What carries the light in this object, or in a frame without objects.
    pub fn carrier(&self, transport: ShadingMethod, object: Option<usize>) -> Carrier {
        let solves = object.is_some_and(|object| self.objects[object].solves());
        Carrier::new(transport, self.method.scheme, solves)
    }

    /// What carries the light in the translucent objects, each carrier once; at least one.
    pub fn carriers(&self, transport: ShadingMethod) -> Vec<Carrier> {
        let translucent = (0..self.objects.len()).filter(|&object| !self.objects[object].opaque);
        let mut carriers: Vec<Carrier> = Vec::new();
        for carrier in translucent.map(|object| self.carrier(transport, Some(object))) {
            if !carriers.contains(&carrier) {
                carriers.push(carrier);
            }
        }
        if carriers.is_empty() {
            carriers.push(self.carrier(transport, None));
        }
        carriers
    }
}
