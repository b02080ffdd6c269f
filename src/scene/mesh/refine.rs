//! A mesh made finer as a hierarchy wants it: a coarse base cut in four, or the mesh wrapped anew.

use super::Mesh;
use super::butterfly::butterfly;
use super::walk;
use super::wrap::{Share, apply, shrink_wrap};
use crate::error::Input;
use crate::scene::range::Checked;
use crate::scene::transport::{Hierarchy, Transport};
use glam::DVec3;

/// How often a base is cut in four, where the scene does not say.
const LEVELS: u32 = 4;

/// Fewest triangles of a base then, of those that are made here: with fewer a thing of many limbs loses some.
const BASE: usize = 200;

/// Most triangles after that.
const MOST: usize = 1 << 23;

/// How the vertices of an object come from those of its file.
#[derive(Debug)]
pub(in crate::scene) enum Origin {
    /// They are the same.
    File,
    /// By subdivision of this base, so many times.
    Butterfly(Box<Mesh>, u32),
    /// Each from three of the file's.
    Wrapped(Vec<Share>),
}

impl Origin {
    /// Where the object's vertices are if the file's are here.
    pub fn apply(&self, positions: Vec<DVec3>) -> Vec<DVec3> {
        match self {
            Self::File => positions,
            Self::Butterfly(base, levels) => butterfly(&Mesh { positions, ..(**base).clone() }, *levels).positions,
            Self::Wrapped(shares) => apply(shares, &positions),
        }
    }
}

impl Mesh {
    /// The mesh as its hierarchy wants it, and where its vertices come from.
    pub(in crate::scene) fn refined(self, transport: &Transport, report: &mut Vec<String>) -> Checked<(Self, Origin)> {
        let (key, levels) = ("transport.hierarchy", transport.levels.unwrap_or(LEVELS));
        match transport.hierarchy {
            Hierarchy::FaceClusters | Hierarchy::Median => Ok((self, Origin::File)),
            Hierarchy::Butterfly => {
                walk::check(&self, key)?;
                let (base, all) = (self.triangles.len(), self.triangles.len() << (2 * levels));
                if all > MOST {
                    let fault = Input::new("too many triangles after subdivision").key("transport.levels");
                    return Err(fault
                        .found(format!("{base} x 4^{levels} = {all}"))
                        .expected(format!("at most {MOST}")));
                }
                Ok((butterfly(&self, levels), Origin::Butterfly(Box::new(self), levels)))
            }
            Hierarchy::ShrinkWrap if self.uvs.is_some() => {
                let fault = Input::new("a shrink-wrapped mesh has no places in a texture").key(key);
                Err(fault.found("an object with material.texture").expected("another hierarchy, or no texture"))
            }
            Hierarchy::ShrinkWrap => {
                let all = self.triangles.len();
                let usual = (1..=LEVELS).rev().find(|levels| all >> (2 * levels) >= BASE).unwrap_or(1);
                let (mesh, shares) = shrink_wrap(&self, transport.levels.unwrap_or(usual), key, report)?;
                Ok((mesh, Origin::Wrapped(shares)))
            }
        }
    }
}
