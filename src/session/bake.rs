//! Depth maps from meshes: at each texel of a surface's texture coordinates, how far below it other surfaces lie
//! (Francois et al. 2006, section 2.1).

use glam::DVec3;
use rayon::prelude::*;

use super::run::Session;
use crate::error::{Input, Result};
use crate::geometry::trace::{UNFINISHED, trace};
use crate::layout::Buffers;
use crate::pipeline::plan::Change;
use crate::prepare::textures::texels;
use crate::prepare::units::Units;
use crate::scene::{Memory, Mesh, Scene};
use crate::state::narrow;
use crate::state::options::{Options, ShadingMethod};

/// Depths of up to four surfaces below another, by texel, rows from the top.
pub struct Baked {
    /// Scene units; 0 in the channels of absent surfaces.
    pub depths: Vec<[f64; 4]>,
    /// The greatest depth, above 0.
    pub deepest: f64,
    /// Texels whose centres lie in a triangle's texture coordinates; the others copy the nearest one.
    pub covered: usize,
    /// Texels with a ray that hit nothing: the depth there is the greatest one.
    pub missed: usize,
    /// For each surface, the rays that hit it from behind: there it lies outside the outer surface, or faces inwards.
    pub behind: Vec<usize>,
}

/// A session whose tree is ready for rays.
fn ready(scene: &Scene) -> Result<Session> {
    let options = Options { transport: ShadingMethod::None, ..Options::default() };
    let mut session = Session::new(scene, None, options)?;
    session.frame(Change::EVERYTHING)?;
    Ok(session)
}

/// Vertex normals: the normalised sum of the vector areas of the triangles around each vertex.
fn normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for (face, corners) in mesh.triangles.iter().enumerate() {
        if let Some([a, b, c]) = mesh.corners(face) {
            corners.iter().for_each(|&v| sums[v as usize] += (b - a).cross(c - a));
        }
    }
    sums.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// Bytes per texel of the map, and per texel found to be covered by a triangle.
const MAP_BYTES: u64 = 160;
const FOUND_BYTES: u64 = size_of::<(usize, [(f64, bool); 4])>() as u64;

/// Most times that the bounding boxes of all triangles together may cover the map.
const MOST_TIMES: f64 = 32.0;

/// Texels of a triangle's bounding box, about: covered ones are searched there.
fn across(uvs: &[[f64; 2]; 3], size: [u32; 2]) -> f64 {
    let extent = |k: usize| {
        let [a, b, c] = uvs.map(|uv| uv[k]);
        (a.max(b).max(c) - a.min(b).min(c)) * f64::from(size[k]) + 1.0
    };
    extent(0) * extent(1)
}

/// Whether a map of this size can be baked, in time and memory.
fn check_size(uvs: &[[[f64; 2]; 3]], size: [u32; 2], memory: Memory) -> Result<()> {
    let places = size[0] as usize * size[1] as usize;
    let across = |uvs: &[[f64; 2]; 3]| across(uvs, size);
    let looked_at: f64 = uvs.iter().map(across).sum();
    let most = MOST_TIMES * places as f64 + MOST_TIMES * uvs.len() as f64;
    if looked_at > most {
        let fault = Input::new("the texture's places are repeated too often to be baked");
        let found = format!("triangles that go over {:.0} times the map", looked_at / places as f64);
        return Err(fault.found(found).expected(format!("at most {MOST_TIMES} times, places from 0 to 1")).into());
    }
    let largest = uvs.iter().map(across).fold(places as f64, f64::max);
    let needed = memory.need(places as u64 * MAP_BYTES + largest as u64 * FOUND_BYTES);
    Ok(needed.map_err(|error| Input::new("the map is too large").key("--size").found(error))?)
}

/// A ray down from a texel's surface point: for each surface below its length, and whether it hits it from behind.
fn down(below: &[(&Buffers, &Units)], at: DVec3, normal: DVec3) -> [(f64, bool); 4] {
    std::array::from_fn(|k| {
        let Some((data, units)) = below.get(k) else { return (0.0, false) };
        let hit = trace(data, narrow(units.inside(at)), narrow(-normal));
        if hit.face >= UNFINISHED {
            return (f64::INFINITY, false);
        }
        let corner =
            |k: usize| DVec3::from(data.in_scene()[data.triangles[hit.face as usize][k] as usize].map(f64::from));
        let [a, b, c] = [0, 1, 2].map(corner);
        let behind = (b - a).cross(c - a).dot(normal) < 0.0;
        (f64::from(hit.numerator / hit.denominator) / units.length, behind)
    })
}

/// Depths below the first object of `outer`, which has texture coordinates, of the first objects of up to four
/// `inner` scenes in the same unit, each clamped to at least the one before. `memory` limits the memory.
pub fn bake(outer: &Scene, inner: &[Scene], size: [u32; 2], memory: Memory) -> Result<Baked> {
    let mesh = &outer.objects[0].mesh;
    let uvs = mesh.uvs.as_deref().unwrap_or_default();
    let sessions = inner.iter().map(ready).collect::<Result<Vec<_>>>()?;
    let below: Vec<_> = sessions.iter().map(|session| (&session.state().data, session.units())).collect();
    let (normals, places) = (normals(mesh), size[0] as usize * size[1] as usize);

    check_size(uvs, size, memory)?;
    let of_face = |face: usize| -> Vec<(usize, [(f64, bool); 4])> {
        let corners = mesh.triangles[face].map(|v| v as usize);
        let mix = |values: &[DVec3], weights: [f64; 3]| -> DVec3 {
            corners.iter().zip(weights).map(|(&v, weight)| weight * values[v]).sum()
        };
        let found = texels(size, &uvs[face].map(|[u, v]| [u, 1.0 - v]));
        let depth = |w: [f64; 3]| down(&below, mix(&mesh.positions, w), mix(&normals, w).normalize_or_zero());
        found.into_iter().map(|(texel, weights)| (texel, depth(weights))).collect()
    };
    let mut depths: Vec<Option<[f64; 4]>> = vec![None; places];
    let (mut behind, mut done) = (vec![0; inner.len()], 0);
    while done < uvs.len() {
        // A batch of triangles: as many as cover the map once, at least one.
        let mut room = places as f64;
        let fit = |uvs: &&[[f64; 2]; 3]| {
            room -= across(uvs, size);
            room >= 0.0
        };
        let end = done + uvs[done..].iter().take_while(fit).count().max(1);
        let found: Vec<_> = (done..end).into_par_iter().map(of_face).collect();
        for (texel, found) in found.into_iter().flatten() {
            if depths[texel].is_none() {
                depths[texel] = Some(found.map(|(depth, _)| depth));
                behind.iter_mut().zip(found).for_each(|(count, (_, is))| *count += usize::from(is));
            }
        }
        done = end;
    }
    let covered = depths.iter().flatten().count();
    let finite = depths.iter().flatten().flatten().copied().filter(|depth| depth.is_finite());
    let deepest = finite.fold(0.0, f64::max);
    if deepest <= 0.0 {
        let fault = Input::new("no ray down from the outer surface meets an inner one");
        return Err(fault.expected("inner surfaces within the outer one, which has texture coordinates").into());
    }

    // Rays that hit nothing get the greatest depth; empty texels get the nearest one.
    let missed = depths.iter().flatten().filter(|depth| depth.iter().any(|d| d.is_infinite())).count();
    for depth in depths.iter_mut().flatten() {
        let mut before = 0f64;
        for d in depth.iter_mut().take(inner.len()) {
            before = before.max(d.min(deepest));
            *d = before;
        }
    }
    // Where coordinates go beyond an edge of the map, the map repeats, and one edge continues at the other.
    let repeats = [0, 1].map(|axis| uvs.iter().flatten().any(|uv| !(-1e-6..=1.0 + 1e-6).contains(&uv[axis])));
    Ok(Baked { depths: fill_outward(depths, size, repeats), deepest, covered, missed, behind })
}

/// Gives each empty texel the value of its neighbours, ring after ring, around the edges of an axis that repeats.
fn fill_outward(mut depths: Vec<Option<[f64; 4]>>, [width, height]: [u32; 2], repeats: [bool; 2]) -> Vec<[f64; 4]> {
    let (w, h) = (width as usize, height as usize);
    let next = |at: usize, size: usize, repeats: bool| {
        if at + 1 < size {
            at + 1
        } else if repeats {
            0
        } else {
            at
        }
    };
    let before = |at: usize, size: usize, repeats: bool| {
        if at > 0 {
            at - 1
        } else if repeats {
            size - 1
        } else {
            at
        }
    };
    let around = |k: usize| {
        let (x, y) = (k % w, k / w);
        [
            y * w + next(x, w, repeats[0]),
            y * w + before(x, w, repeats[0]),
            next(y, h, repeats[1]) * w + x,
            before(y, h, repeats[1]) * w + x,
        ]
    };
    let mut edge: Vec<usize> = (0..w * h).filter(|&k| depths[k].is_some()).collect();
    while !edge.is_empty() {
        let mut next = Vec::new();
        for k in edge {
            for other in around(k) {
                if depths[other].is_none() {
                    depths[other] = depths[k];
                    next.push(other);
                }
            }
        }
        edge = next;
    }
    depths.into_iter().map(Option::unwrap_or_default).collect()
}
