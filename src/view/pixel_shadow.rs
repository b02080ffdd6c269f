//! Stage `pixel_shadow`: whether each light reaches the point that a pixel shows, by a ray from that point: shadow
//! borders are as sharp as the picture, however coarse the triangles. It shadows opaque objects, and the reflections of
//! lights on all objects; and, where an environment is occluded, it traces the rays along which that is reflected.

use rayon::prelude::*;

use super::mirror_ray::{Seen, mirror_ray};
use super::pixel_receivers::place;
use crate::error::Result;
use crate::layout::{
    BufferId, LIGHT_BRIGHT_RAY, LIGHT_MIRROR_RAY, LIGHT_SKY_RAY, Light, NONE, OPAQUE_BY_PIXEL, ObjectParams,
    REFLECTION_NONE, Rays,
};
use crate::lighting::pixel_light::pixel_light;
use crate::lighting::shadow::{RAYS, free};
use crate::state::{Local, Need, Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "pixel_shadow",
    about: "whether each light reaches the point that a pixel shows: rays through the tree, one bit per ray",
    equation: "the visibility in equation 5; any triangle between blocks",
    writes: &[
        (BufferId::pixel_lit, Role::Output, Tolerance::Exact),
        (BufferId::cut_short, Role::Update, Tolerance::Exact),
    ],
    reason: "decisions, bit for bit",
    sizes: &[(
        BufferId::pixel_lit,
        Size::Elements(|state| state.data.camera.first().map_or(0, |c| c.shadow_words as usize) * state.pixels()),
    )],
    needs: &[Need::Light, Need::Picture],
    skip,
    ..super::stage(cpu, gpu)
};

fn skip(state: &State) -> Option<&'static str> {
    let unshadowed = state.data.camera.iter().all(|camera| camera.shadow_words == 0);
    match state.data.pixel_lights.is_empty() {
        true => Some("no opaque object is lit where the pixels show it, and none reflects a light"),
        false if unshadowed => Some("no light casts shadows, and no environment asks what is hidden of it"),
        false => None,
    }
}

/// Whether this is a ray of reflections.
fn mirrors(light: &Light) -> bool {
    [LIGHT_MIRROR_RAY, LIGHT_BRIGHT_RAY].contains(&light.kind)
}

/// Whether a light of this kind is needed at the pixels of an object: to light it, or to be reflected.
fn asked(params: &ObjectParams, kind: u32) -> bool {
    let reflects = params.reflection != REFLECTION_NONE;
    match kind {
        LIGHT_MIRROR_RAY | LIGHT_BRIGHT_RAY => reflects,
        LIGHT_SKY_RAY => params.opaque == OPAQUE_BY_PIXEL,
        _ => params.opaque == OPAQUE_BY_PIXEL || reflects,
    }
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let words = data.camera[0].shadow_words as usize;
    let casting: Vec<usize> =
        (0..data.pixel_lights.len()).filter(|&number| data.pixel_lights[number].shadow != NONE).collect();
    let mut reached = vec![0; words * data.hits.len()];
    reached.par_chunks_mut(words.max(1)).zip(&data.hits).enumerate().for_each(|(pixel, (bits, hit))| {
        let Some(&corners) = data.triangles.get(hit.face as usize) else { return };
        let params = &data.object_params[state.object_of(hit.face as usize)];
        let origin = place(hit, corners.map(|v| data.in_scene()[v as usize]));
        let normal = place(hit, corners.map(|v| data.normals_in_scene()[v as usize]));
        let seen = Seen::new(data, hit, corners);
        for &number in &casting {
            let light = &data.pixel_lights[number];
            let reaches = |light: &Light| free(state, hit.face, origin, light);
            let free = asked(params, light.kind)
                && if mirrors(light) {
                    let ray = mirror_ray(data, light, pixel, &seen, params);
                    !seen.traced(&ray) || reaches(&ray)
                } else {
                    reaches(&pixel_light(data, number, pixel, normal))
                };
            bits[light.shadow as usize / 32] |= u32::from(free) << (light.shadow % 32);
        }
    });
    state.data.pixel_lit = reached;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let others = u32::from(pass.state.method.local.is_some_and(Local::spares_itself));
    for light in (0..data.pixel_lights.len()).filter(|&light| data.pixel_lights[light].shadow != NONE) {
        let mirror = u32::from(mirrors(&data.pixel_lights[light]));
        let constants = [pass.state.objects.len() as u32, others, mirror];
        for first in (0..data.hits.len()).step_by(RAYS) {
            let count = RAYS.min(data.hits.len() - first);
            let rays = Rays { object: 0, first: first as u32, count: count as u32, light: light as u32 };
            pass.dispatch(None, &constants, bytemuck::bytes_of(&rays), count)?;
        }
    }
    Ok(())
}
