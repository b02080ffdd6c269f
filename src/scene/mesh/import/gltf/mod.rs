//! Reads glTF 2.0 (.gltf, .glb): the triangles of all meshes in the file's scene, each where its node or its joints
//! place it. A part is all triangles of one material.

use super::{Coordinates, LARGEST, MOST_UV, Soup, Texels, checked, colors, compact};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use crate::scene::skin::{Pose, Rig};
use document::Document;
use std::collections::HashSet;
use std::path::Path;
use toml::Table;
use tree::{Local, Tree};

mod animation;
mod assembly;
mod document;
mod material;
mod parse;
mod primitive;
mod scene;
mod tint;
mod tree;

use assembly::Assembly;
use tint::Tint;

/// Reads the mesh of a part, or of all parts, from a file's bytes; what the file names is beside `path`. `wanted` are
/// texture coordinates and normals.
pub(super) fn read(
    files: &Files,
    path: &Path,
    bytes: &[u8],
    part: Option<u32>,
    (wanted, normals): (Option<Coordinates<'_>>, bool),
) -> Checked<Soup> {
    let document = Document::open(files, path, bytes)?;
    let tree = Tree::of(&document)?;
    let parts = Parts::of(&document, &tree, part)?;
    let assembly = Assembly::of(&document, files, &tree, &Local::rest(&document), &parts.chosen)?;
    let positions = assembly.positions();
    let positions: Checked<Vec<_>> =
        positions.enumerate().map(|(number, position)| checked(position, number)).collect();
    let input_face = (0..).take(assembly.triangles.len()).collect();
    let uvs = match wanted {
        None => None,
        Some(wanted) if wanted.own => {
            let tint = Tint::of(&document, &tree, &parts).map_err(|fault| fault.key(wanted.key))?;
            Some(tint.corners(&document, files, &assembly)?)
        }
        Some(wanted) => Some(assembly.uvs(&document, files, None).and_then(|uvs| {
            let what = "the mesh has no texture coordinates, or not at every corner";
            uvs.ok_or_else(|| Input::new(what).key(wanted.key).expected("TEXCOORD_0 in every primitive"))
        })?),
    };
    let far = |place: &[f64; 2]| place.iter().any(|x| !(-MOST_UV..=MOST_UV).contains(x));
    if let Some(place) = uvs.iter().flatten().flatten().find(|place| far(place)) {
        let fault = Input::new("a texture coordinate is out of range").found(format!("{place:?}"));
        return Err(fault.expected("numbers from -10,000 to 10,000"));
    }
    let normals = if normals { assembly.normals(&document, files) } else { None };
    let corners = assembly.triangles.clone().into_iter().flatten();
    let (soup, _) = compact(&positions?, corners, assembly.triangles, input_face);
    // Say it once for a file whose parts are objects.
    let notes = if part.is_none_or(|part| part == 0) { document.ignored() } else { None };
    Ok(Soup { uvs, normals, notes: notes.into_iter().collect(), ..soup })
}

/// The texture of a part.
pub(super) fn texture(files: &Files, path: &Path, bytes: &[u8], part: Option<u32>) -> Checked<Texels> {
    let document = Document::open(files, path, bytes)?;
    let tree = Tree::of(&document)?;
    let parts = Parts::of(&document, &tree, part)?;
    let tint = Tint::of(&document, &tree, &parts)?;
    tint.texels(&document, files, path, &tree, &parts)
}

/// The scene of a file alone, and notes on it: `around`, with an object for each part and the file's own camera and
/// lights where it has any.
pub(super) fn scene(files: &Files, path: &Path, bytes: &[u8], around: Table) -> Checked<(Table, Vec<String>)> {
    let document = Document::open(files, path, bytes)?;
    scene::scene(&document, files, around)
}

/// Names of a file's animations, and how long they last, in seconds.
pub(super) fn animations(files: &Files, path: &Path, bytes: &[u8]) -> Checked<Vec<(String, f64)>> {
    animation::names(&Document::open(files, path, bytes)?, files)
}

/// The mesh of a part, its rig, and two poses: at rest, and as animation `number` has it at a time in seconds.
pub(super) fn animated(
    files: &Files,
    path: &Path,
    bytes: &[u8],
    part: Option<u32>,
    (number, time): (usize, f64),
) -> Checked<(Soup, Rig, [Pose; 2])> {
    let document = Document::open(files, path, bytes)?;
    let tree = Tree::of(&document)?;
    let parts = Parts::of(&document, &tree, part)?;
    let mut locals = Local::rest(&document);
    let rest = Assembly::of(&document, files, &tree, &locals, &parts.chosen)?;
    animation::pose(&document, files, number, time, &mut locals)?;
    let now = Assembly::of(&document, files, &tree, &locals, &parts.chosen)?;
    let input_face = (0..).take(rest.triangles.len()).collect();
    let positions: Vec<_> = rest.positions().collect();
    let (soup, from) =
        compact(&positions, rest.triangles.iter().flatten().copied(), rest.triangles.clone(), input_face);
    Ok((soup, rest.rig(&from)?, [rest.pose(), now.pose()]))
}

/// The materials of the primitives that are shown, and which of them are chosen; `None` is glTF's default material.
struct Parts {
    /// All of them, in the order of first use.
    all: Vec<Option<usize>>,
    /// Those that are chosen.
    chosen: Vec<Option<usize>>,
}

impl Parts {
    fn of(document: &Document, tree: &Tree, part: Option<u32>) -> Checked<Self> {
        let (mut all, mut seen) = (Vec::new(), HashSet::new());
        for primitive in assembly::primitives(document, tree)?.into_iter().map(|(_, primitive)| primitive) {
            let material = primitive.material.map(|material| material.value());
            if let Some(material) = material.filter(|material| *material >= document.root.materials.len()) {
                return Err(document::gone("material", material));
            }
            if seen.insert(material) {
                all.push(material);
            }
        }
        if all.is_empty() {
            let fault = Input::new("the mesh has no faces").found("no triangles in the scene of the file");
            return Err(fault.expected("a glTF file whose scene has meshes of triangles"));
        }
        let chosen = match part {
            None => all.clone(),
            Some(part) => match all.get(part as usize) {
                Some(material) => vec![*material],
                None => {
                    let fault = Input::new("the mesh has no such part").found(part);
                    return Err(fault.expected(format!("0 to {}, one for each material", all.len() - 1)));
                }
            },
        };
        Ok(Self { all, chosen })
    }
}

#[cfg(test)]
mod tests;
