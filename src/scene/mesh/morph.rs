//! Morph targets: the positions of a mesh's vertices in two files of equal topology. Animations: their rigs and poses.

use super::{Mesh, clean, import, twice};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use crate::scene::skin::{Pose, Rig};
use glam::DVec3;
use std::path::Path;

impl Mesh {
    /// The rig of the mesh read from `path`, or of a part of it, and its poses at rest and at a time: `at` is the
    /// number of an animation and the time in seconds.
    pub(in crate::scene) fn read_animated(
        files: &Files,
        (path, part): (&Path, Option<u32>),
        at: (usize, f64),
    ) -> Checked<(Rig, [Pose; 2])> {
        let (soup, rig, poses) = import::animated(files, path, part, at)?;
        let (_, from) = clean::clean(soup, &mut Vec::new()).map_err(|fault| fault.file(path))?;
        let unread = |error| Input::new("the animation does not fit the memory").file(path).found(error);
        files.take(from.len() as u64 * Rig::bytes(rig.joints, rig.targets)).map_err(unread)?;
        Ok((rig.of(&from), poses))
    }

    /// The positions of the vertices of the mesh read from `source`, a part of a file, in that file and in `other`,
    /// whose key for errors is `key`. Both must have the same number of vertices and the same triangles in the same
    /// order; vertices that coincide in the first must coincide in the other.
    pub(in crate::scene) fn read_ends(
        files: &Files,
        source: (&Path, Option<u32>),
        other: &Path,
        key: &str,
    ) -> Checked<[Vec<DVec3>; 2]> {
        let (path, part) = source;
        let [rest, end] = [path, other].map(|path| import::read(files, path, part, None, false));
        let (rest, end) = (rest?, end?);
        let fault = |what: &str, found: String, expected: String| {
            Err(Input::new(what).key(key).found(found).expected(expected))
        };
        let count =
            |soup: &import::Soup| format!("{} vertices in {} triangles", soup.positions.len(), soup.triangles.len());
        let [here, there] = [path, other].map(|path| path.display().to_string());
        let what = "the meshes do not match one to one";
        if rest.positions.len() != end.positions.len() || rest.triangles.len() != end.triangles.len() {
            return fault(what, format!("{} in {there}", count(&end)), format!("{} as in {here}", count(&rest)));
        }
        // The same polygon may be cut in another way where its corners have moved: compare borders.
        let rims = [&rest, &end].map(|soup| twice::borders(&soup.triangles, &soup.input_face));
        if let Some(first) = (0..rest.triangles.len()).find(|&k| rims[0][k] != rims[1][k]) {
            let face = end.input_face[first] + 1;
            let expected = format!("the faces of {here}, of the same vertices in the same order");
            return fault(what, format!("other vertices from face {face} of {there} on"), expected);
        }
        let (first, _) = clean::weld(&rest.positions);
        let parts = |&(&first, place): &(&u32, &DVec3)| end.positions[first as usize] != *place;
        let parted = first.iter().zip(&end.positions).filter(parts).count();
        if parted > 0 {
            let found = format!("{parted} vertices that coincide with others in {here} but not in {there}");
            return fault(what, found, "vertices that coincide in the one to coincide in the other".into());
        }
        let places = rest.positions.clone();
        let (_, from) = clean::clean(rest, &mut Vec::new()).map_err(|fault| fault.file(path))?;
        Ok([places, end.positions].map(|places| from.iter().map(|&v| places[v as usize]).collect()))
    }
}
