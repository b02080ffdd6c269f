//! Lines for the user on long triangles: which were divided, and which were left.

use super::run::Session;
use super::subdivide::Parts;
use crate::prepare::coarse::Long;
use crate::scene::{Object, Receivers};
use crate::state::options::ShadingMethod;

impl Session {
    /// A line for each object whose triangles were divided, or would be if it did not deform.
    #[must_use]
    pub fn divisions(&self) -> Vec<String> {
        let asked = self.fixed.asked.iter().flat_map(|asked| &asked.objects);
        let line = |((number, asked), parts): ((usize, &Object), &Parts)| {
            let whole = asked.mesh.triangles.len();
            parts.long.map(|left| {
                let left = if left > 0 { format!(", of which {left} are long still") } else { String::new() };
                format!(
                    "object {number}: triangles longer than the distance over which radiosity changes at edges are \
                     divided: {whole} become {}{left} (transport.receivers = \"faces\" leaves them)",
                    parts.of.len()
                )
            })
        };
        let deforms = |(number, object): (usize, &Object)| {
            let auto = self.scene.transport.receivers == Receivers::Auto && !object.deforms.is_empty();
            (auto && Long::of(&object.mesh, &object.material).is_some()).then(|| {
                format!(
                    "object {number}: triangles longer than the distance over which radiosity changes at edges are not \
                     divided, since it deforms"
                )
            })
        };
        let deformed = self.scene.objects.iter().enumerate().filter_map(deforms);
        asked.enumerate().zip(&self.parts).filter_map(line).chain(deformed).collect()
    }

    /// Whether each triangle of the state is one that would be divided, but was not since its object deforms or
    /// receivers are to be the triangles as they are; empty if none is.
    #[must_use]
    pub fn left_long(&self) -> Vec<bool> {
        let (mut all, transport) = (Vec::new(), &self.scene.transport);
        if self.fixed.options.transport == ShadingMethod::Walk {
            // The values of a walk are means.
            return all;
        }
        for (number, object) in self.scene.objects.iter().enumerate() {
            // Only objects that deform, or whose triangles stay as they are because that was asked for.
            if object.deforms.is_empty() && (transport.receivers != Receivers::Faces || !self.parts.is_empty()) {
                continue;
            }
            let Some(long) = Long::of(&object.mesh, &object.material) else { continue };
            all.resize(self.state().data.triangles.len(), false);
            for (face, place) in self.prepared.places(number).into_iter().enumerate() {
                all[place] = object.mesh.corners(face).is_some_and(|corners| long.is(corners));
            }
        }
        all
    }
}
