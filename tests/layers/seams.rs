//! Texture seams: a mesh of two islands looks like the same mesh in one piece.

use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3};
use milkglass::internals::layers::islands::{Whole, atlas};
use milkglass::internals::layers::relief;
use milkglass::internals::layout::Hit;
use milkglass::internals::pipeline::plan::{Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Scope;
use milkglass::scene::{DepthMap, Mesh, Scene, Wrap};

use super::{scene, session};

/// Texels along a side of the square.
const SIDE: f64 = 96.0;
/// Upper left corners of the two halves in the common map, in texels.
const LEFT: [f64; 2] = [9.0, 7.0];
const RIGHT: [f64; 2] = [64.0, 30.0];
const SIZE: [u32; 2] = [180, 120];

/// A square of 20 mm facing +y, viewed obliquely across its middle, in one piece or as two islands; with its depth at x
/// and z from -0.5 to 0.5.
fn square(whole: bool, depth_at: impl Fn(f64, f64) -> f64) -> Scene {
    let layers = "object.0.material={ layers = { samples = 24, layer = [\
        { sigma_s = 2, sigma_t = 2.2, thickness = 1 }, { sigma_s = 0.3, sigma_t = 3, g = 0.3, thickness = 1 }] } }";
    let sets = [
        "camera={ position = [16.0, 9.0, 5.0], target = [0.0, 0.0, 0.0], size = [48, 32], fov = 16 }",
        "light=[{ type = 'directional', direction = [-2, 1, 0.4], irradiance = 3 }]",
        "object.0.shape=plane",
        "object.0.size=20",
        "object.0.detail=8",
        "object.0.rotation=[0, 0, 0]",
        layers,
    ];
    let mut scene = scene("slab-layers", &sets);
    let mesh = &mut scene.objects[0].mesh;
    let right = |corners: &[u32; 3]| corners.iter().map(|&v| mesh.positions[v as usize].x).sum::<f64>() > 0.0;
    // Texels from the upper left; the right half is rotated by 90 degrees.
    let place = |x: f64, z: f64, right: bool| match (whole, right) {
        (true, _) => [(x + 0.5) * SIDE, (z + 0.5) * SIDE],
        (_, false) => [LEFT[0] + (x + 0.5) * SIDE, LEFT[1] + (z + 0.5) * SIDE],
        (_, true) => [RIGHT[0] + (0.5 - z) * SIDE, RIGHT[1] + x * SIDE],
    };
    let size = if whole { [SIDE as u32; 2] } else { SIZE };
    let uv = |[u, v]: [f64; 2]| [u / f64::from(size[0]), 1.0 - v / f64::from(size[1])];
    let corner = |v: u32| mesh.positions[v as usize] / 20.0;
    let uvs = mesh.triangles.iter().map(|t| t.map(|v| uv(place(corner(v).x, corner(v).z, right(t))))).collect();
    mesh.uvs = Some(uvs);

    // Texels outside both halves lie at the surface.
    let depth = |k: u32| {
        let (u, v) = (f64::from(k % size[0]) + 0.5, f64::from(k / size[0]) + 0.5);
        let half = |[u0, v0]: [f64; 2], [w, h]: [f64; 2]| u > u0 && v > v0 && u < u0 + w && v < v0 + h;
        if whole {
            depth_at(u / SIDE - 0.5, v / SIDE - 0.5)
        } else if half(LEFT, [SIDE / 2.0, SIDE]) {
            depth_at((u - LEFT[0]) / SIDE - 0.5, (v - LEFT[1]) / SIDE - 0.5)
        } else if half(RIGHT, [SIDE, SIDE / 2.0]) {
            depth_at((v - RIGHT[1]) / SIDE, 0.5 - (u - RIGHT[0]) / SIDE)
        } else {
            0.0
        }
    };
    let depths: Vec<f64> = (0..size[0] * size[1]).flat_map(|k| [depth(k), 1.5]).collect();
    scene.objects[0].material.layers.as_mut().unwrap().map = DepthMap::new(size, 2, &depths, Wrap::Clamp).unwrap();
    scene
}

fn taken(scene: &Scene) -> Session {
    session(scene, Options { transport: ShadingMethod::None, ..Options::default() })
}

/// Radiance of the pixels that show places within 2.5 mm of the square's centre, so that no ray comes near its edges.
/// With `ignored`, the user's map is sampled directly, without islands.
fn seen(scene: &Scene, ignored: bool) -> Vec<f64> {
    let session = taken(scene);
    let mut state = session.state().clone();
    if ignored {
        let map = &scene.objects[0].material.layers.as_ref().unwrap().map;
        let length = session.units().length;
        state.data.layerings[0].first_island = u32::MAX;
        state.data.layerings[0].size = map.size;
        let inside = |x: f32| if x < 1e30 { (f64::from(x) * length) as f32 } else { x };
        state.data.depths = map.texels.iter().map(|texel| texel.map(inside)).collect();
    }
    state.data.radiance.iter_mut().for_each(|pixel| *pixel = [0.0; 3]);
    (relief::STAGE.cpu)(&mut state, Scope::default());
    let middle = |hit: &Hit| {
        let corners = state.data.triangles.get(hit.face as usize)?.map(|v| state.data.positions[v as usize]);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let along = |k: usize| (0..3).map(|i| f64::from(weights[i] * corners[i][k])).sum::<f64>();
        let place = session.units().outside(DVec3::new(along(0), along(1), along(2)));
        Some(place.abs().max_element() < 2.5)
    };
    let shown = state.data.hits.iter().zip(&state.data.radiance).filter(|(hit, _)| middle(hit) == Some(true));
    shown.map(|(_, pixel)| f64::from(pixel[0])).collect()
}

/// The largest difference between the square in one piece and in two, relative to the mean of the first.
fn apart(depth_at: impl Fn(f64, f64) -> f64 + Copy, ignored: bool) -> f64 {
    let (a, b) = (seen(&square(true, depth_at), false), seen(&square(false, depth_at), ignored));
    let mean = a.iter().sum::<f64>() / a.len() as f64;
    assert!(mean > 0.0 && a.len() > 300 && a.len() == b.len(), "{mean} {}", a.len());
    a.iter().zip(&b).map(|(a, b)| (a - b).abs() / mean).fold(0.0, f64::max)
}

#[test]
fn even_depths_on_two_islands_look_as_in_one_piece() {
    let [parted, ignored] = [false, true].map(|ignored| apart(|_, _| 0.5, ignored));
    assert!(parted < 1e-5, "{parted}");
    assert!(ignored > 0.1, "{ignored}");
}

#[test]
fn depths_that_go_on_over_a_seam_do_not_show_it() {
    let wavy = |x: f64, z: f64| 0.6 + 0.4 * (9.0 * x + 4.0 * z).sin() * (7.0 * z - 2.0 * x).cos();
    let [parted, ignored] = [false, true].map(|ignored| apart(wavy, ignored));
    // Both halves have the same texel positions; interpolation reads the margins between them.
    assert!(parted < 5e-3, "{parted}");
    assert!(ignored > 0.1, "{ignored}");
}

#[test]
fn texels_that_triangles_cover_stay_as_they_are() {
    let two = square(false, |x, z| 0.6 + 0.3 * (20.0 * x).sin() * (15.0 * z).cos());
    let (mesh, map) = (&two.objects[0].mesh, &two.objects[0].material.layers.as_ref().unwrap().map);
    let made = atlas(mesh, map, 4.0).unwrap();
    assert_eq!((made.islands, made.seams, made.share), (2, 8, 1.0));
    assert_eq!(made.margin, (4.0 * SIDE / 20.0).ceil() as u32);
    let mut found = 0;
    for (face, island) in made.places.iter().enumerate() {
        // The texel nearest to each triangle's centroid, which lies between texels.
        let near = |x: f64| (x + 0.25).round() as u32;
        let middle = |k: usize| near(f64::from((island.a[k] + island.b[k] + island.c[k]) / 3.0));
        let [x, y] = [middle(0), middle(1)];
        let [u, v] = [0, 1].map(|k| mesh.uvs.as_ref().unwrap()[face].iter().map(|uv| uv[k]).sum::<f64>() / 3.0);
        let own = [u * f64::from(SIZE[0]) - 0.5, (1.0 - v) * f64::from(SIZE[1]) - 0.5].map(near);
        assert_eq!(made.texels[(y * made.size[0] + x) as usize], map.texels[(own[1] * SIZE[0] + own[0]) as usize]);
        found += 1;
    }
    assert_eq!(found, mesh.triangles.len());
}

#[test]
fn margins_hold_the_surface_across_the_seam_and_its_end_beyond_that() {
    let linear = |x: f64, z: f64| 0.6 + 0.4 * x - 0.3 * z;
    let mut two = square(false, linear);
    // The right half's outer quarter is an island of its own, 25 rows farther down.
    let object = &mut two.objects[0];
    let positions = &object.mesh.positions;
    let outer = |corners: &[u32; 3]| corners.iter().all(|&v| positions[v as usize].x > 7.4);
    for (corners, uvs) in object.mesh.triangles.iter().zip(object.mesh.uvs.as_mut().unwrap()) {
        uvs.iter_mut().filter(|_| outer(corners)).for_each(|uv| uv[1] -= 25.0 / f64::from(SIZE[1]));
    }
    let texels = Arc::make_mut(&mut object.material.layers.as_mut().unwrap().map.texels);
    let [first, last] = [0.375, 0.5].map(|x| (RIGHT[1] + x * SIDE) as usize);
    for row in first..last {
        let [from, to] = [row, row + 25].map(|row| row * SIZE[0] as usize + RIGHT[0] as usize);
        texels.copy_within(from..from + SIDE as usize, to);
        texels[from..from + SIDE as usize].fill([0.0; 4]);
    }
    let (mesh, map) = (&two.objects[0].mesh, &two.objects[0].material.layers.as_ref().unwrap().map);
    // Margins are wider than the other half.
    let made = atlas(mesh, map, 14.0).unwrap();
    assert!(made.islands == 3 && made.share == 1.0 && f64::from(made.margin) > 0.6 * SIDE);
    let mut found = [[0; 2]; 2];
    for right in [false, true] {
        let side = |corners: &[u32; 3]| corners.iter().map(|&v| mesh.positions[v as usize].x).sum::<f64>() > 0.0;
        let face = mesh.triangles.iter().position(|corners| side(corners) == right).unwrap();
        let (island, corners) = (&made.places[face], mesh.triangles[face].map(|v| mesh.positions[v as usize] / 20.0));
        // The island's texels by x and z, from one of its triangles.
        let [a, b, c] = [island.a, island.b, island.c].map(|p| DVec2::from_array(p.map(f64::from)));
        let [p, q, r] = corners.map(|corner| DVec2::new(corner.x, corner.z));
        let to_square = DMat2::from_cols(q - p, r - p) * DMat2::from_cols(b - a, c - a).inverse();
        for (y, x) in (island.low[1] as u32..=island.high[1] as u32)
            .flat_map(|y| (island.low[0] as u32..=island.high[0] as u32).map(move |x| (y, x)))
        {
            let at = p + to_square * (DVec2::new(x.into(), y.into()) - a);
            let beyond = if right { -at.x } else { at.x };
            if beyond > 1e-6 && at.y.abs() < 0.499 {
                let value = f64::from(made.texels[(y * made.size[0] + x) as usize][0]);
                let expected = linear(at.x.clamp(-0.5, 0.5), at.y);
                assert!((value - expected).abs() < 6e-3, "{at}: {value}, not {expected}");
                found[usize::from(right)][usize::from(beyond > 0.5)] += 1;
            }
        }
    }
    assert!(found.as_flattened().iter().all(|&texels| texels > 1000), "{found:?}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_mesh_without_seams_has_none_of_it() {
    for name in ["fish", "gecko", "veins"] {
        let scene = scene(name, &["camera.size=[8, 8]"]);
        let session = taken(&scene);
        assert!(session.state().data.islands.is_empty());
        assert_eq!(session.maps(), ["object 0: its maps have no seams, and are taken as they are"], "{name}");
        // With a map that does not repeat, only `veins` has a seam.
        let mut map = scene.objects[0].material.layers.as_ref().unwrap().map.clone();
        map.wrap = Wrap::Clamp;
        let seams = atlas(&scene.objects[0].mesh, &map, 1.0);
        assert_eq!(seams.is_ok(), name == "veins", "{name}");
    }
    let even = taken(&scene("slab-layers", &["camera.size=[8, 8]"]));
    assert!(even.maps().is_empty() && even.state().data.islands.is_empty());
    let two = taken(&square(false, |_, _| 0.5));
    assert!(!two.state().data.islands.is_empty());
    assert!(two.maps()[0].starts_with("object 0: 2 islands in its maps meet at 8 edges"), "{:?}", two.maps());
}

#[test]
fn islands_that_take_too_much_are_left_alone() {
    // Half of a square, with texture coordinates that cover the map a million times.
    let mut two = square(false, |_, _| 0.5);
    for corners in two.objects[0].mesh.uvs.iter_mut().flatten().flatten() {
        *corners = corners.map(|x| 1000.0 * x);
    }
    let (mesh, map) = (&two.objects[0].mesh, &two.objects[0].material.layers.as_ref().unwrap().map);
    assert!(matches!(atlas(mesh, map, 1.0), Err(Whole::TooLarge(texels)) if texels > 1 << 30));
}

#[test]
fn triangles_that_lie_over_one_another_are_left_alone() {
    // A strip that folds over one place 3000 times; its last triangle lies elsewhere, which makes a seam.
    let place = |v: &u32| [[0.05, 0.05], [0.95, 0.05], [0.05, 0.95]][*v as usize % 3];
    let triangle = |i: u32| if i.is_multiple_of(2) { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] };
    let triangles: Vec<[u32; 3]> = (0..3000).map(triangle).collect();
    let mut uvs: Vec<[[f64; 2]; 3]> = triangles.iter().map(|corners| corners.each_ref().map(place)).collect();
    uvs[2999] = uvs[2999].map(|[u, v]| [0.5 * u + 0.2, 0.5 * v + 0.2]);
    let mesh = Mesh {
        positions: (0..3002).map(|v| DVec3::new(0.5 * f64::from(v), f64::from(v % 2), 0.0)).collect(),
        input_face: (0..3000).collect(),
        triangles,
        uvs: Some(uvs),
        ..Mesh::default()
    };
    let map = DepthMap::new([2048, 2048], 1, &vec![0.5; 1 << 22], Wrap::Clamp).unwrap();
    assert_eq!(atlas(&mesh, &map, 1.0), Err(Whole::TooFolded));
}
