//! Whether shadows have borders among the triangles: then the error estimate misses something. It judges how light is
//! carried from one value of irradiance per triangle; how far that value is from the light that varies across the
//! triangle only `transport.subdivide` finds out.

use std::collections::HashMap;

use super::run::Session;
use crate::error::Result;
use crate::geometry::plane::Plane;
use crate::layout::{BufferId, LIGHT_DIRECTIONAL, LIGHT_SKY_RAY, Light, NONE};
use crate::lighting::shadow;

impl Session {
    /// Whether the error estimate leaves out borders of shadows, should there be any: some light casts shadows, and
    /// triangles are not subdivided for them.
    #[must_use]
    pub fn leaves_out_borders(&self) -> bool {
        self.state().method.estimate
            && !self.cut_for_light()
            && self.plan().has(&shadow::STAGE)
            && self.state().data.lights.iter().any(casts)
    }

    /// The number of triangles that the error estimate misjudges, since a border of a shadow in the last frame runs
    /// through them or along them: of two neighbours, both turned to a light, it reaches one. 0 if borders are in the
    /// estimate.
    pub fn bordered(&mut self) -> Result<usize> {
        if !self.leaves_out_borders() {
            return Ok(0);
        }
        self.fetch(&[BufferId::lit, BufferId::positions, BufferId::placed_positions])?;
        let (state, data) = (self.state(), &self.state().data);
        let words = data.object_params[0].shadow_words as usize;
        let casting: Vec<&Light> = data.lights.iter().filter(|light| casts(light)).collect();
        let turned = |face: usize, light: &Light| {
            let corners = data.triangles[face].map(|v| data.in_scene()[v as usize]);
            let normal = Plane::new(corners).normal;
            let far = light.kind == LIGHT_DIRECTIONAL;
            let to = |k: usize| light.place[k] - if far { 0.0 } else { corners[0][k] };
            (0..3).map(|k| to(k) * normal[k]).sum::<f32>() > 0.0
        };
        let reached = |face: usize, light: &Light| {
            data.lit[words * face + light.shadow as usize / 32] >> (light.shadow % 32) & 1 != 0
        };
        let mut bordered = vec![false; data.triangles.len()];
        for object in state.objects.iter().filter(|object| !object.opaque) {
            let mut beside: HashMap<[u32; 2], usize> = HashMap::new();
            for face in object.first.faces..object.first.faces + object.count.faces {
                let [a, b, c] = data.triangles[face];
                for edge in [[a, b], [b, c], [c, a]] {
                    let Some(other) = beside.insert([edge[0].min(edge[1]), edge[0].max(edge[1])], face) else {
                        continue;
                    };
                    let differs = |light: &&Light| {
                        reached(face, light) != reached(other, light) && turned(face, light) && turned(other, light)
                    };
                    if casting.iter().any(differs) {
                        (bordered[face], bordered[other]) = (true, true);
                    }
                }
            }
        }
        Ok(bordered.iter().filter(|&&at| at).count())
    }
}

/// Whether a light's shadows have borders: an environment's are spread over all directions.
fn casts(light: &Light) -> bool {
    light.shadow != NONE && light.kind != LIGHT_SKY_RAY
}
