//! Stage `visibility`: the first triangle that each pixel's ray hits.

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::trace::trace;
use crate::geometry::widen::team;
use crate::layout::{BufferId, Camera, Hit, NONE};
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "visibility",
    about: "primary rays through the tree: triangle, barycentric weights and depth of each pixel",
    equation: "sides of edges, seen along the ray; nearest by cross-multiplied fractions",
    writes: &[(BufferId::hits, Role::Output, Tolerance::Float { relative: 2e-6, floor: 1e-6 })],
    reason: "the triangle is a decision, bit for bit; weights and depth are one f32 division each",
    sizes: &[(BufferId::hits, Size::Elements(State::pixels))],
    runs: Update::view,
    ..super::stage(cpu, gpu)
};

/// The ray from the eye through a pixel, exactly as in the shader. It is not normalised, so nothing is divided.
#[must_use]
pub fn ray(camera: &Camera, pixel: u32) -> [f32; 3] {
    let (w, h) = (camera.width as f32, camera.height as f32);
    let (column, row) = (pixel % camera.width, pixel / camera.width);
    let x = ((2 * column + 1) as f32 + camera.shift_x - w) * h;
    let y = (h - ((2 * row + 1) as f32 + camera.shift_y)) * w;
    let z = w * h;
    std::array::from_fn(|k| z * camera.forward[k] + x * camera.right[k] + y * camera.up[k])
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let camera = data.camera[0];
    let (w, h) = (camera.width as f32, camera.height as f32);
    let hit = |pixel: u32| {
        let nearest = trace(data, camera.origin, ray(&camera, pixel));
        if nearest.face == NONE {
            return Hit { face: NONE, ..Hit::default() };
        }
        let weights = nearest.weights.map(f64::from);
        let sum: f64 = weights.iter().sum();
        let depth = f64::from(nearest.numerator) / f64::from(nearest.denominator) * f64::from(w * h);
        Hit { face: nearest.face, u: (weights[1] / sum) as f32, v: (weights[2] / sum) as f32, depth: depth as f32 }
    };
    let hits = (0..camera.width * camera.height).into_par_iter().map(hit).collect();
    state.data.hits = hits;
}

/// Most triangles per pixel with which rays go in teams. Teams take 0.81 of the time with 3.8 (a horse of 96,966 at
/// 160 x 160), but 1.5 times as long with 15 (at 80 x 80).
const MOST_FACES: usize = 6;

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let (camera, faces) = (pass.state.data.camera[0], pass.state.data.triangles.len());
    // Where triangles are much smaller than pixels, neighbouring rays have few triangles in common.
    let dense = faces > MOST_FACES * pass.state.data.hits.len();
    // Tiles of two rows, in teams.
    let team = if dense { 1 } else { team(pass.width().subgroup) };
    let (width, height) =
        (camera.width.next_multiple_of((team / 2).max(1)), camera.height.next_multiple_of(team.min(2)));
    pass.dispatch(None, &[team], &[], width as usize * height as usize)
}
