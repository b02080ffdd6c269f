//! Stage `pixel_shadow`: whether each light that casts shadows reaches the point of an opaque object that a pixel
//! shows, by a ray from that point: shadow borders are as sharp as the picture, however coarse the triangles.

use rayon::prelude::*;

use super::pixel_receivers::place;
use crate::error::Result;
use crate::layout::{BufferId, Light, NONE, Rays};
use crate::lighting::shadow::{RAYS, free};
use crate::state::{Carrier, Granularity, Need, Pass, Role, Scope, Serves, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "pixel_shadow",
    module: "view",
    about: "whether each light reaches the point of an opaque object that a pixel shows: rays through the tree, one bit per ray",
    equation: "the visibility in equation 5; any triangle between blocks",
    writes: &[
        (BufferId::pixel_lit, Role::Output, Tolerance::Exact),
        (BufferId::cut_short, Role::Update, Tolerance::Exact),
    ],
    reason: "decisions, bit for bit",
    sizes: &[(
        BufferId::pixel_lit,
        Size::Elements(|state| state.data.object_params[0].shadow_words as usize * state.pixels()),
    )],
    granularity: Granularity::Scene,
    carriers: Carrier::ALL,
    needs: &[Need::Light, Need::Picture],
    serves: Serves { object: |object, _| object.plain(), none: "no opaque object is lit where the pixels show it" },
    skip,
    runs: Update::picture,
    cpu,
    gpu,
};

fn skip(state: &State) -> Option<&'static str> {
    let unshadowed = state.data.object_params.iter().all(|params| params.shadow_words == 0);
    unshadowed.then_some("no light casts shadows, and no environment asks what is hidden of it")
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let words = data.object_params[0].shadow_words as usize;
    let casting: Vec<&Light> = data.lights.iter().filter(|light| light.shadow != NONE).collect();
    let mut reached = vec![0; words * data.hits.len()];
    reached.par_chunks_mut(words.max(1)).zip(&data.hits).for_each(|(bits, hit)| {
        let Some(&corners) = data.triangles.get(hit.face as usize) else { return };
        if !state.objects[state.object_of(hit.face as usize)].plain() {
            return;
        }
        let place = place(hit, corners.map(|v| data.in_scene()[v as usize]));
        for light in &casting {
            bits[light.shadow as usize / 32] |= u32::from(free(state, hit.face, place, light)) << (light.shadow % 32);
        }
    });
    state.data.pixel_lit = reached;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let objects = pass.state.objects.len() as u32;
    for light in (0..data.lights.len()).filter(|&light| data.lights[light].shadow != NONE) {
        for first in (0..data.hits.len()).step_by(RAYS) {
            let count = RAYS.min(data.hits.len() - first);
            let rays = Rays { object: 0, first: first as u32, count: count as u32, light: light as u32 };
            pass.dispatch(None, &[objects], bytemuck::bytes_of(&rays), count)?;
        }
    }
    Ok(())
}
