//! Stage `shadow`: whether each light that casts shadows reaches each face, by one ray from the centroid.

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::occlusion::{Ray, blocked};
use crate::geometry::placement::placed;
use crate::geometry::plane::Plane;
use crate::geometry::widen::team;
use crate::layout::{BufferId, LIGHT_AREA, LIGHT_DIRECTIONAL, LIGHT_SKY_RAY, LIGHT_SPOT, Light, NONE, Rays};
use crate::state::{Granularity, Local, Object, Pass, Role, Scope, Serves, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "shadow",
    about: "whether each light reaches each face: rays through the tree, one bit per ray",
    equation: "the visibility in equation 5; any triangle between blocks",
    writes: &[(BufferId::lit, Role::Output, Tolerance::Exact), (BufferId::cut_short, Role::Update, Tolerance::Exact)],
    reason: "decisions, bit for bit",
    sizes: &[(BufferId::cut_short, Size::Elements(|_| 1))],
    granularity: Granularity::Scene,
    serves: Serves {
        object: |object, _| object.lit_by_face(),
        none: "every object is opaque, and lit where the pixels show it",
    },
    skip,
    ..super::stage(cpu, gpu)
};

fn skip(state: &State) -> Option<&'static str> {
    let alone = state.method.local.is_some_and(Local::spares_itself)
        && state.objects.len() == 1
        && state.objects.iter().all(|object| !object.opaque);
    match state.data.object_params.iter().all(|params| params.shadow_words == 0) {
        _ if alone => Some("an object does not shadow itself in local shading, and there is no other"),
        true => Some("no light casts shadows, and no environment asks what is hidden of it"),
        false => None,
    }
}

/// Most rays of one dispatch: about a second on the slowest device.
pub const RAYS: usize = 1 << 18;

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let words = data.object_params[0].shadow_words as usize;
    let casting: Vec<&Light> = data.lights.iter().filter(|light| light.shadow != NONE).collect();
    let of_face = |face: usize, bits: &mut [u32]| {
        bits.fill(0);
        let object = state.object_of(face);
        let node = state.objects[object].first.nodes + data.leaves[face] as usize;
        let origin = placed(&data.object_params[object], data.clusters[node].center);
        for light in &casting {
            let free = free(state, face as u32, origin, light);
            bits[light.shadow as usize / 32] |= u32::from(free) << (light.shadow % 32);
        }
    };
    let mut lit = data.lit.clone();
    for object in state.objects.iter().filter(|object| object.lit_by_face()) {
        let first = object.first.faces;
        let part = &mut lit[words * first..words * (first + object.count.faces)];
        part.par_chunks_mut(words.max(1)).enumerate().for_each(|(face, bits)| of_face(first + face, bits));
    }
    state.data.lit = lit;
}

/// Whether an object is shadowed by other objects only.
fn others_only(state: &State, object: &Object) -> bool {
    state.method.local.is_some_and(Local::spares_itself) && !object.opaque
}

/// Whether a light reaches a point of a triangle.
#[must_use]
pub fn free(state: &State, face: u32, place: [f32; 3], light: &Light) -> bool {
    ray(state, face, place, light).is_some_and(|ray| !blocked(&state.data, &ray))
}

/// The ray from a point of a triangle to a light; none where the triangle faces away, behind an area light, or
/// outside a spot's cone.
fn ray(state: &State, face: u32, origin: [f32; 3], light: &Light) -> Option<Ray> {
    let data = &state.data;
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let far = light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY;
    let direction = if far { light.place } else { std::array::from_fn(|k| light.place[k] - origin[k]) };
    // In local shading an object's own triangles do not block light, nor does it matter which way they face.
    let number = state.object_of(face as usize);
    let (object, both) = (&state.objects[number], data.object_params[number].two_sided != 0);
    let spared = others_only(state, object).then(|| {
        let first = object.first.faces as u32;
        first..first + object.count.faces as u32
    });
    let plane = Plane::new(data.triangles[face as usize].map(|v| data.in_scene()[v as usize]));
    let facing = dot(direction, plane.normal);
    let along = -dot(direction, light.axis);
    let cosine = 1.0 - light.outer;
    let shines = match light.kind {
        LIGHT_SPOT => along > 0.0 && along * along > cosine * cosine * dot(direction, direction),
        LIGHT_AREA => along > 0.0,
        _ => true,
    };
    let wanted = shines && (spared.is_some() || facing > 0.0 || (both && facing < 0.0));
    let side = if facing > 0.0 { 1.0 } else { -1.0 };
    wanted.then_some(Ray { face, origin, direction, light: (!far).then_some(light.place), side, spared })
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let lights = &pass.state.data.lights;
    // On a GPU a team shares one ray: its way takes a step for each wide node, and there are as many more invocations.
    let width = pass.width();
    let team = team(width.subgroup);
    let spread = width.shares && team > 1;
    let a_ray = if spread { team as usize } else { 1 };
    let objects = pass.state.objects.iter().enumerate();
    for (number, object) in objects.filter(|(_, object)| object.lit_by_face()) {
        let others = u32::from(others_only(pass.state, object));
        let end = object.first.faces + object.count.faces;
        for light in (0..lights.len()).filter(|&light| lights[light].shadow != NONE) {
            for first in (object.first.faces..end).step_by(RAYS) {
                let count = RAYS.min(end - first);
                let [object, first, faces, light] = [number, first, count, light].map(|n| n as u32);
                pass.dispatch(
                    None,
                    &[others, team, u32::from(spread)],
                    bytemuck::bytes_of(&Rays { object, first, count: faces, light }),
                    count * a_ray,
                )?;
            }
        }
    }
    Ok(())
}
