//! Texture charts for the stages `bake_irradiance`, `blur` and `texture_blur`: the surface point at each texel, and
//! the Gaussians.

use super::material::dipoles;
use super::scene::Prepared;
use super::textures::texels;
use crate::error::{Input, Result};
use crate::layout::{TexelHit, Unwrapping};
use crate::scene::{Object, Scene};
use crate::shading::gaussians::fit;
use crate::state::Local;

/// The triangles of an object's mesh that its texels show.
pub(crate) struct Unwrapped {
    charts: Vec<TexelHit>,
    /// Whether the surface continues across the right edge at the left one, and across the bottom at the top.
    round: [bool; 2],
}

/// Most times that the bounding boxes of all triangles together may cover the texture.
const MOST_TIMES: f64 = 32.0;
/// The share of covered texels that may show several triangles.
const SHARED: f64 = 0.01;
/// A texel that shows no surface.
const NOTHING: TexelHit = TexelHit { face: u32::MAX, u: 0.0, v: 0.0 };

/// The texture charts of every translucent object; an error where one has no texture coordinates, or where they are
/// not one to one. Empty unless light is blurred over textures.
pub(crate) fn unwrap(scene: &Scene, local: Option<Local>) -> Result<Vec<Option<Unwrapped>>> {
    if local != Some(Local::Blur) {
        return Ok(Vec::new());
    }
    let side = scene.transport.blur_texture;
    let charts_of = |(number, object): (usize, &Object)| match object.material.opaque {
        Some(_) => Ok(None),
        None => of_object(number, object, side).map(Some),
    };
    scene.objects.iter().enumerate().map(charts_of).collect()
}

fn of_object(number: usize, object: &Object, side: u32) -> Result<Unwrapped> {
    let key = format!("object.{number}");
    let Some(uvs) = object.mesh.uvs.as_deref() else {
        let fault = Input::new("light is blurred over texture coordinates, and the mesh has none").key(key);
        return Err(fault.expected("transport.unwrap = true, and a mesh with texture coordinates").into());
    };
    let (places, length) = (side as usize * side as usize, f64::from(side));
    let down: Vec<_> = uvs.iter().map(|uvs| uvs.map(|[u, v]| [u, 1.0 - v])).collect();
    let ends = |face: &[[f64; 2]; 3], axis: usize| {
        let all = face.map(|place| place[axis]);
        (all.into_iter().fold(f64::INFINITY, f64::min), all.into_iter().fold(f64::NEG_INFINITY, f64::max))
    };
    let over = |face: &[[f64; 2]; 3]| [0, 1].map(|axis| (ends(face, axis).1 - ends(face, axis).0) * length + 1.0);
    let looked_at: f64 = down.iter().map(|face| over(face).iter().product::<f64>()).sum();
    if looked_at > MOST_TIMES * (places + uvs.len()) as f64 {
        let fault = Input::new("triangles go over the texture too often for light to be blurred over it").key(key);
        let found = format!("{:.0} times", looked_at / places as f64);
        return Err(fault.found(found).expected("texture coordinates that are one to one").into());
    }
    // If a triangle crosses an edge, the surface continues at the opposite one.
    let crosses = |face: &[[f64; 2]; 3], axis: usize| {
        let (low, high) = ends(face, axis);
        (low + 1e-6).floor() < (high - 1e-6).floor()
    };
    let round = [0, 1].map(|axis| down.iter().any(|face| crosses(face, axis)));

    // The first triangle that covers a texel's centre, and the texels that show several.
    let mut charts = vec![NOTHING; places];
    let mut shared = vec![false; places];
    let mut missed = Vec::new();
    for (face, corners) in (0u32..).zip(&down) {
        let found = texels([side; 2], corners);
        if found.is_empty() {
            missed.push((face, corners));
        }
        for (texel, [_, u, v]) in found {
            let inside = u.min(v).min(1.0 - u - v) > 1e-6;
            if charts[texel].face == u32::MAX {
                charts[texel] = TexelHit { face, u: u as f32, v: v as f32 };
            } else {
                shared[texel] |= inside && charts[texel].face != face;
            }
        }
    }
    // A triangle that covers no texel's centre gets the texel at its centroid, if that is still empty.
    for (face, corners) in missed {
        let middle = [0, 1].map(|axis| corners.iter().map(|place| place[axis]).sum::<f64>() / 3.0);
        let [x, y] = middle.map(|at| ((at * length).floor() as i64).rem_euclid(i64::from(side)) as usize);
        let chart = &mut charts[y * side as usize + x];
        if chart.face == u32::MAX {
            *chart = TexelHit { face, u: 1.0 / 3.0, v: 1.0 / 3.0 };
        }
    }
    let covered = charts.iter().filter(|chart| chart.face != u32::MAX).count();
    let several = shared.iter().filter(|&&several| several).count() as f64 / covered.max(1) as f64;
    if several > SHARED {
        let fault = Input::new("parts of the mesh lie over each other in its texture coordinates").key(key);
        let found = format!("{:.0} % of what they cover shows several triangles", 100.0 * several);
        return Err(fault.found(found).expected("texture coordinates that are one to one").into());
    }
    Ok(Unwrapped { charts, round })
}

/// Adds the charts and the Gaussians to the state.
pub(crate) fn blur(prepared: &mut Prepared, scene: &Scene, unwrapped: Vec<Option<Unwrapped>>) {
    for (number, unwrapped) in unwrapped.into_iter().enumerate() {
        let Some(Unwrapped { charts, round }) = unwrapped else { continue };
        let places = prepared.places(number);
        let data = &mut prepared.state.data;
        let first = data.texel_hits.len() as u32;
        data.texel_hits.extend(charts.into_iter().map(|chart| match places.get(chart.face as usize) {
            Some(&face) => TexelHit { face: face as u32, ..chart },
            None => chart,
        }));
        data.unwrappings.push(Unwrapping {
            object: number as u32,
            first,
            side: scene.transport.blur_texture,
            round: round.map(u32::from),
        });
        data.object_params[number].irradiance_map = data.unwrappings.len() as u32;
        data.gaussians.extend(fit(&dipoles(&scene.objects[number].material, prepared.units.length)).records());
    }
}
