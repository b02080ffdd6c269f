//! Stage `shadow`: whether each light that casts shadows reaches each face, a ray from the centroid each.

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::occlusion::{Ray, blocked};
use crate::geometry::plane::Plane;
use crate::layout::{Buffers, Light, Rays, Slot};
use crate::state::{Pass, Place, Role, Stage, State, Tolerance, Unit};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "shadow",
    room: "light",
    about: "whether each light reaches each face: rays through the tree, a bit each",
    equation: "the visibility in equation 5; any triangle between blocks",
    writes: &[(Slot::lit, Role::Output, Tolerance::Exact), (Slot::cut_short, Role::Update, Tolerance::Exact)],
    reason: "decisions, bit for bit",
    unit: Unit::Frame,
    cpu,
    gpu,
};

/// Rays of one dispatch at most: about a second on the slowest device.
const RAYS: usize = 1 << 18;

fn cpu(state: &mut State, _at: Place) {
    let data = &state.data;
    let words = data.frame[0].shadow_words as usize;
    let both = data.frame[0].two_sided != 0;
    let casting: Vec<&Light> = data.lights.iter().filter(|light| light.shadow != u32::MAX).collect();
    let of_face = |face: usize| {
        let mut bits = vec![0u32; words];
        for light in &casting {
            let free = ray(data, face as u32, light, both).is_some_and(|ray| !blocked(data, &ray));
            bits[light.shadow as usize / 32] |= u32::from(free) << (light.shadow % 32);
        }
        bits
    };
    let lit = (0..data.triangles.len()).into_par_iter().flat_map_iter(of_face).collect();
    state.data.lit = lit;
}

/// The ray from a face to a light; none where the face is turned away, behind an area, or outside a spot's cone.
fn ray(data: &Buffers, face: u32, light: &Light, both: bool) -> Option<Ray> {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let origin = data.clusters[data.leaves[face as usize] as usize].center;
    let far = light.kind == 0 || light.kind == 5;
    let direction = if far { light.place } else { std::array::from_fn(|k| light.place[k] - origin[k]) };
    let own = Plane::new(data.triangles[face as usize].map(|v| data.positions[v as usize]));
    let facing = dot(direction, own.normal);
    let along = -dot(direction, light.axis);
    let cosine = 1.0 - light.outer;
    let shines = match light.kind {
        2 => along > 0.0 && along * along > cosine * cosine * dot(direction, direction),
        3 => along > 0.0,
        _ => true,
    };
    let wanted = shines && (facing > 0.0 || (both && facing < 0.0));
    let side = if facing > 0.0 { 1.0 } else { -1.0 };
    wanted.then_some(Ray { face, origin, direction, light: (!far).then_some(light.place), side })
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let faces = data.triangles.len();
    for light in (0..data.lights.len()).filter(|&light| data.lights[light].shadow != u32::MAX) {
        for first in (0..faces).step_by(RAYS) {
            let count = RAYS.min(faces - first);
            let rays = Rays { first: first as u32, count: count as u32, light: light as u32 };
            pass.dispatch(None, &[], bytemuck::bytes_of(&rays), count)?;
        }
    }
    Ok(())
}
