//! A texture's mean over a face, where it is known: a texture that grows evenly across has the mean of its centroid.

use glam::DVec3;
use milkglass::scene::{Scene, Side, Texture, Wrap};

use super::{irradiance, mesh, scene};

const SIZE: u32 = 64;

/// Value of the texture at u and v, from 0 to 1, v up.
fn ramp(u: f64, v: f64) -> DVec3 {
    DVec3::new(0.1 + 0.8 * u, 0.9 - 0.7 * v, 0.2 + 0.3 * u + 0.4 * v)
}

fn ramped() -> Texture {
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(SIZE);
    let texel = |k: u32| ramp(at(k % SIZE), 1.0 - at(k / SIZE)).to_array().map(|x| x as f32);
    Texture::new([SIZE; 2], (0..SIZE * SIZE).map(texel).collect(), Side::Entry, Wrap::Clamp)
}

/// A row of triangles in the sun, which take these places of the texture.
fn triangles(uvs: &[[[f64; 2]; 3]]) -> Scene {
    let mut scene = scene("sphere", &["light=[{ type = 'directional', direction = [0.2, 0.1, 1], irradiance = 1 }]"]);
    let corners = |k: usize| [[0.0, 0.0], [0.8, 0.0], [0.3, 0.9]].map(|[x, y]| DVec3::new(x + k as f64, y, 0.0));
    let count = uvs.len() as u32;
    scene.objects[0].mesh =
        mesh((0..uvs.len()).flat_map(corners).collect(), (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
    scene.objects[0].mesh.uvs = Some(uvs.to_vec());
    scene
}

#[test]
fn every_part_of_a_face_counts_once_in_its_mean() {
    // From a fraction of a texel to most of the texture, upright and inverted, away from the edges.
    let sizes = (1..=40).map(|k| 0.02 * f64::from(k));
    let uvs: Vec<[[f64; 2]; 3]> = sizes
        .flat_map(|size| {
            let at = |u: f64, v: f64| [0.1 + size * u, 0.1 + size * v];
            [[at(0.0, 0.0), at(1.0, 0.1), at(0.2, 0.9)], [at(1.0, 1.0), at(0.05, 0.6), at(0.7, 0.0)]]
        })
        .collect();
    let bare = triangles(&uvs);
    let mut painted = bare.clone();
    painted.objects[0].material.texture = Some(ramped());
    let [bare, painted] = [bare, painted].map(|scene| irradiance(&scene));
    assert_eq!(bare.len(), uvs.len());
    for ((bare, painted), corners) in bare.iter().zip(&painted).zip(&uvs) {
        let [u, v] = [0, 1].map(|axis| corners.iter().map(|uv| uv[axis]).sum::<f64>() / 3.0);
        let (found, expected) = (*painted / *bare, ramp(u, v));
        assert!((found - expected).abs().max_element() < 2e-5, "{corners:?}: {found}, not {expected}");
    }
}
