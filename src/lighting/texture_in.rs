//! Stage `texture_in`: multiplies the light that enters a face by the texture's mean over the face.
//!
//! The mean is taken over the centroids of n x n equal triangles that the face is cut into, where n is the longest
//! extent of an edge along either axis of the texture, in texels, from 1 to [`TEXTURE_PARTS`]. Longer faces are only
//! sampled: not every texel counts.

use rayon::prelude::*;

use super::texture::{factor, place, untextured};
use crate::error::Result;
use crate::layout::{BufferId, Buffers, CornerUvs, TEXTURE_ENTERS, TEXTURE_PARTS};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "texture_in",
    about: "irradiance of each face times the texture's mean over it",
    equation: "d'Eon et al. 2007, pre-scatter texturing",
    writes: &[(BufferId::irradiance, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a place in the texture is off by about 1e-7, times its texels per unit and their contrast",
    skip: |state| untextured(state, TEXTURE_ENTERS),
    ..super::stage(cpu, gpu)
};

/// The number of parts along an edge; decided in `f32` both here and in the shader.
fn parts(uvs: &CornerUvs, size: [u32; 2]) -> u32 {
    let along = |axis: usize| {
        let edge = |p: [f32; 2], q: [f32; 2]| (q[axis] - p[axis]).abs() * size[axis] as f32;
        edge(uvs.a, uvs.b).max(edge(uvs.b, uvs.c)).max(edge(uvs.c, uvs.a))
    };
    along(0).max(along(1)).ceil().clamp(1.0, TEXTURE_PARTS as f32) as u32
}

/// Weights of the second and third corner at the centroid of part `k` of n x n.
fn part(k: u32, n: u32) -> (f64, f64) {
    let (i, j) = (k / n, k % n);
    // Parts that are upside down lie beyond the diagonal, and are counted from the far corner.
    let (i, j, third) = if i + j < n { (i, j, 1.0 / 3.0) } else { (n - 1 - i, n - 1 - j, 2.0 / 3.0) };
    ((f64::from(i) + third) / f64::from(n), (f64::from(j) + third) / f64::from(n))
}

/// Irradiance of a face after the texture.
fn entered(data: &Buffers, face: usize) -> [f32; 3] {
    let n = parts(&data.corner_uvs[face], data.object_params[0].texture_size);
    let at = |k: u32| {
        let (u, v) = part(k, n);
        factor(&data.object_params[0], &data.texels, place(data, face, u, v))
    };
    let mean = (0..n * n).map(at).sum::<glam::DVec3>() / f64::from(n * n);
    narrow(wide(data.irradiance[face]) * mean)
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    if data.object_params[0].texture_side & TEXTURE_ENTERS != 0 {
        state.data.irradiance = (0..data.triangles.len()).into_par_iter().map(|face| entered(data, face)).collect();
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.faces)
}

#[cfg(test)]
mod tests {
    use crate::lighting::texture_in::*;

    #[test]
    fn parts_lie_inside_and_their_mean_is_the_centroid() {
        for n in [1, 2, 5, TEXTURE_PARTS] {
            let places: Vec<_> = (0..n * n).map(|k| part(k, n)).collect();
            assert!(places.iter().all(|&(u, v)| u > 0.0 && v > 0.0 && u + v < 1.0));
            let mean = |weight: fn(&(f64, f64)) -> f64| places.iter().map(weight).sum::<f64>() / f64::from(n * n);
            assert!((mean(|p| p.0) - 1.0 / 3.0).abs() < 1e-12 && (mean(|p| p.1) - 1.0 / 3.0).abs() < 1e-12);
            let mut seen: Vec<_> = places.iter().map(|&(u, v)| ((u * 3e3) as u32, (v * 3e3) as u32)).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), places.len());
        }
    }

    #[test]
    fn a_face_is_cut_as_finely_as_its_texels() {
        let uvs = CornerUvs { a: [0.0, 0.5], b: [0.25, 0.5], c: [0.0, 0.625] };
        assert_eq!(parts(&uvs, [8, 8]), 2);
        assert_eq!(parts(&uvs, [9, 8]), 3);
        assert_eq!(parts(&uvs, [8, 30]), 4);
        assert_eq!((parts(&uvs, [1, 1]), parts(&uvs, [4096, 1])), (1, TEXTURE_PARTS));
    }
}
