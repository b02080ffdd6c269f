//! Refines a mesh for its hierarchy: by subdivision of a coarse base, or by shrink-wrapping.

use super::Mesh;
use super::butterfly::butterfly;
use super::walk;
use super::wrap::{Share, apply, shrink_wrap};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use crate::scene::transport::{Hierarchy, Transport};
use glam::DVec3;

/// Default levels of 4-to-1 subdivision.
const LEVELS: u32 = 4;

/// Minimum triangles of a base made by shrink-wrapping with the default levels: with fewer, a shape of many limbs loses
/// some.
const BASE: usize = 200;

/// Maximum triangles after subdivision.
const MOST: usize = 1 << 23;

/// How the vertices of an object come from those of its file.
#[derive(Debug)]
pub(in crate::scene) enum Origin {
    /// The vertices of the file.
    File,
    /// By subdividing this base so many times.
    Butterfly(Box<Mesh>, u32),
    /// Each vertex is a weighted mean of three of the file's.
    Wrapped(Vec<Share>),
}

impl Origin {
    /// Approximate number of the object's vertices; 0 if they are those of its file.
    pub fn vertices(&self) -> usize {
        match self {
            Self::File => 0,
            Self::Butterfly(base, levels) => base.positions.len() << (2 * levels),
            Self::Wrapped(shares) => shares.len(),
        }
    }

    /// Positions of the object's vertices from those of the file's.
    pub fn apply(&self, positions: Vec<DVec3>) -> Vec<DVec3> {
        match self {
            Self::File => positions,
            Self::Butterfly(base, levels) => butterfly(&Mesh { positions, ..(**base).clone() }, *levels).positions,
            Self::Wrapped(shares) => apply(shares, &positions),
        }
    }
}

/// Maximum triangles at a vertex of a base: the scheme visits all of them for each of its edges.
const MOST_ROUND: u32 = 4096;

/// Checks that no vertex has too many triangles.
fn crowds(mesh: &Mesh, key: &str) -> Checked<()> {
    match mesh.round().into_iter().max() {
        Some(most) if most > MOST_ROUND => {
            let fault = Input::new("too many triangles at one vertex to be subdivided").key(key).found(most);
            Err(fault.expected(format!("at most {MOST_ROUND}")))
        }
        _ => Ok(()),
    }
}

/// Checks that a base may be split in four so often, and takes the memory.
pub(super) fn room(files: &Files, base: usize, levels: u32) -> Checked<()> {
    let all = base << (2 * levels);
    let fault = |what: &str, found: String| {
        let fault = Input::new(what).key("transport.levels");
        fault.found(format!("{base} x 4^{levels} = {all}{found}")).expected(format!("at most {MOST}"))
    };
    if all > MOST {
        return Err(fault("too many triangles after subdivision", String::new()));
    }
    let bytes = all as u64 * Mesh::BYTES;
    files.take(bytes).map_err(|error| fault("the triangles do not fit the memory", format!(": {error}")))
}

impl Mesh {
    /// Refines the mesh for its hierarchy; also returns the origin of its vertices.
    pub(in crate::scene) fn refined(
        self,
        files: &Files,
        transport: &Transport,
        report: &mut Vec<String>,
    ) -> Checked<(Self, Origin)> {
        let (key, levels) = ("transport.hierarchy", transport.levels.unwrap_or(LEVELS));
        match transport.hierarchy {
            Hierarchy::FaceClusters | Hierarchy::Median => Ok((self, Origin::File)),
            Hierarchy::Butterfly => {
                walk::check(&self, key)?;
                crowds(&self, key)?;
                room(files, self.triangles.len(), levels)?;
                Ok((butterfly(&self, levels), Origin::Butterfly(Box::new(self), levels)))
            }
            Hierarchy::ShrinkWrap if self.uvs.is_some() => {
                let fault = Input::new("a shrink-wrapped mesh has no places in a texture").key(key);
                Err(fault.found("an object with material.texture").expected("another hierarchy, or no texture"))
            }
            Hierarchy::ShrinkWrap => {
                crowds(&self, key)?;
                let all = self.triangles.len();
                let usual = (1..=LEVELS).rev().find(|levels| all >> (2 * levels) >= BASE).unwrap_or(1);
                let (mesh, shares) = shrink_wrap(&self, transport.levels.unwrap_or(usual), files, report)?;
                Ok((mesh, Origin::Wrapped(shares)))
            }
        }
    }
}
