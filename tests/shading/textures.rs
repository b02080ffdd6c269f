//! Textures: their effect on light that enters and on light that leaves, and their placement on a ball.

use std::f64::consts::TAU;

use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::{Scene, Side, Texture, Wrap};

/// A small ball with a checker texture and these settings.
fn ball(sets: &[&str]) -> Scene {
    let small = ["object.0.detail=3", "camera.size=[48, 40]", "object.0.material.texture=builtin:checker"];
    let sets: Vec<_> = small.iter().chain(sets).map(ToString::to_string).collect();
    Scene::load_with("sphere", &sets).unwrap()
}

/// The same ball with this texture, or with none.
fn painted(texture: Option<Texture>) -> Scene {
    let mut scene = ball(&[]);
    scene.objects[0].material.texture = texture;
    scene
}

/// A session after one frame on the CPU.
fn drawn(scene: &Scene, options: Options) -> Session {
    let mut session = Session::new(scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn grey(value: f32, side: Side) -> Option<Texture> {
    Some(Texture::new([1, 1], vec![[value; 3]], side, Wrap::Repeat))
}

/// Whether all numbers of `found` are `factor` times those of `bare`, within a relative `slack`.
fn scaled(found: &[[f32; 3]], bare: &[[f32; 3]], factor: f32, slack: f32) -> bool {
    let near = |(a, b): (&f32, &f32)| (a - factor * b).abs() <= slack * factor * b;
    assert!(found.len() == bare.len() && bare.as_flattened().iter().any(|&x| x > 0.0));
    found.as_flattened().iter().zip(bare.as_flattened()).all(near)
}

#[test]
fn half_a_texture_is_half_the_light() {
    let background =
        |scene: Scene| Scene { camera: milkglass::scene::Camera { background: [0.0; 3], ..scene.camera }, ..scene };
    let run = |texture| drawn(&background(painted(texture)), Options::default());
    let mut bare = run(None);
    let (light, picture) = (bare.state().data.radiosity.clone(), bare.picture().unwrap().pixels);
    for (side, leaves) in [(Side::Exit, 1.0), (Side::Entry, 0.5), (Side::Both, 0.5f32.sqrt())] {
        let mut half = run(grey(0.5, side));
        assert!(scaled(&half.state().data.radiosity, &light, leaves, 1e-5), "{side:?}");
        assert!(scaled(&half.picture().unwrap().pixels, &picture, 0.5, 1e-5), "{side:?}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_enters_through_a_texture_and_its_complement_adds_up() {
    let tiles = ball(&["object.0.material.texture=builtin:tiles"]).objects[0].material.texture.clone().unwrap();
    let tinted = |turn: fn(f32) -> f32| {
        let texels = tiles.texels.iter().map(|texel| texel.map(turn)).collect();
        Some(Texture::new(tiles.size, texels, Side::Entry, Wrap::Repeat))
    };
    for transport in [ShadingMethod::Hierarchy, ShadingMethod::Brute, ShadingMethod::Octree] {
        let run = |texture| drawn(&painted(texture), Options { transport, ..Options::default() });
        let [all, some, rest] =
            [None, tinted(|x| x), tinted(|x| 1.0 - x)].map(|texture| run(texture).state().data.radiosity.clone());
        let (mut error, mut size) = (0.0, 0.0);
        for (k, all) in all.as_flattened().iter().enumerate() {
            error += (some.as_flattened()[k] + rest.as_flattened()[k] - all).powi(2);
            size += all * all;
        }
        // The octree's clustering error differs between the three solves.
        let slack = if transport == ShadingMethod::Octree { 0.05 } else { 2e-3 };
        assert!((error / size).sqrt() < slack, "{transport:?}: {}", (error / size).sqrt());
    }
}

#[test]
fn light_is_coloured_once_however_often_it_changes() {
    let scene = ball(&["object.0.material.texture=builtin:tiles", "object.0.material.texture_on=both"]);
    let options = Options { mode: Mode::Render, ..Options::default() };
    let mut kept = drawn(&scene, options);
    let (light, picture) = (kept.state().data.irradiance.clone(), kept.picture().unwrap().pixels);
    let names = |change, session: &mut Session| -> Vec<String> {
        session
            .frame(change)
            .unwrap()
            .into_iter()
            .map(|step| step.name)
            .filter(|name| name.starts_with("texture_"))
            .collect()
    };
    assert_eq!(names(Change::VIEW, &mut kept), ["texture_out"]);
    assert_eq!(names(Change::RESUM, &mut kept), ["texture_out"]);
    for lights in [vec![], scene.lights.clone(), scene.lights.clone()] {
        kept.set_lights(&lights).unwrap();
        assert_eq!(names(Change::LIGHT, &mut kept).len(), if lights.is_empty() { 0 } else { 2 });
    }
    assert_eq!(kept.state().data.irradiance, light);
    assert_eq!(kept.picture().unwrap().pixels, picture);
}

#[test]
fn channels_part_only_where_a_texture_at_the_entry_parts_them() {
    let groups = |texels: Vec<[f32; 3]>, side| {
        let mut scene = painted(Some(Texture::new([2, 1], texels, side, Wrap::Repeat)));
        scene.lights.truncate(1);
        drawn(&scene, Options::default()).state().objects[0].groups.len()
    };
    let colors = vec![[0.5, 0.2, 0.1], [0.1, 0.2, 0.5]];
    assert_eq!((groups(colors.clone(), Side::Entry), groups(colors, Side::Exit)), (3, 1));
    let one = vec![[0.5, 0.25, 0.1], [0.25, 0.125, 0.05]];
    assert_eq!((groups(one.clone(), Side::Entry), groups(one, Side::Both)), (1, 1));
    assert_eq!(groups(vec![[0.5, 0.0, 0.1], [0.2, 0.0, 0.3]], Side::Entry), 2);

    // Blue of a channel group does not depend on the texture's ratio of red to blue.
    let [together, red] = [[0.5, 0.25, 0.1], [0.1, 0.1, 0.1]].map(|texel| {
        drawn(&painted(Some(Texture::new([1, 1], vec![texel], Side::Entry, Wrap::Clamp))), Options::default())
    });
    let blue = |session: &Session| session.state().data.radiosity.iter().map(|b| [b[2]; 3]).collect::<Vec<_>>();
    assert!(scaled(&blue(&together), &blue(&red), 1.0, 2e-3));
    let mut black = drawn(&painted(grey(0.0, Side::Entry)), Options::default());
    assert!(black.state().objects[0].groups.is_empty());
    let hit: Vec<bool> = black.state().data.hits.iter().map(|hit| hit.face != u32::MAX).collect();
    let pixels = black.picture().unwrap().pixels;
    assert!(pixels.iter().zip(hit).all(|(pixel, hit)| !hit || *pixel == [0.0; 3]));
}

#[test]
fn the_seam_of_a_ball_is_not_seen() {
    // Red is darkest at the seam, which the camera faces; green increases upwards.
    let texel = |k: u32| {
        let (u, v) = ((f64::from(k % 128) + 0.5) / 128.0, 1.0 - (f64::from(k / 128) + 0.5) / 64.0);
        [0.5 - 0.4 * (TAU * u).cos(), v, 0.5 + 0.4 * (TAU * u).sin()].map(|x| x as f32)
    };
    let mut scene =
        ball(&["camera.position=[0, 4, -35]", "light.0.direction=[0.2, 0.3, -1]", "camera.target=[0, 0, 0]"]);
    scene.objects[0].material.texture = None;
    let bare = drawn(&scene, Options::default()).picture().unwrap().pixels;
    scene.objects[0].material.texture =
        Some(Texture::new([128, 64], (0..128 * 64).map(texel).collect(), Side::Exit, Wrap::Repeat));
    let mut session = drawn(&scene, Options::default());
    let pixels = session.picture().unwrap().pixels;
    let (data, mut seen) = (&session.state().data, [0; 2]);
    for (pixel, hit) in data.hits.iter().enumerate().filter(|(_, hit)| hit.face != u32::MAX) {
        let corners = data.triangles[hit.face as usize];
        let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let p: glam::Vec3 = (0..3).map(|k| weight[k] * glam::Vec3::from(data.positions[corners[k] as usize])).sum();
        let p = p.as_dvec3().normalize();
        if bare[pixel].contains(&0.0) || p.x.hypot(p.z) < 0.5 {
            continue;
        }
        let turn = p.x.atan2(p.z);
        let expected = [0.5 + 0.4 * turn.cos(), 0.5 + p.y.asin() * 2.0 / TAU, 0.5 - 0.4 * turn.sin()];
        let found = [0, 1, 2].map(|c| f64::from(pixels[pixel][c] / bare[pixel][c]));
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 0.02), "{p}: {found:?} {expected:?}");
        seen[usize::from(p.x > 0.0)] += 1;
    }
    assert!(seen.iter().all(|&seen| seen > 100), "{seen:?}");
}

#[test]
fn numbers_alone_have_no_texture_for_light_that_leaves() {
    let numbers = |side: &str| {
        let scene = ball(&[&format!("object.0.material.texture_on={side}")]);
        let session = drawn(&scene, Options { goal: Goal::Radiosity, ..Options::default() });
        let sizes = [BufferId::texels, BufferId::corner_uvs].map(|slot| session.state().data.bytes(slot).len());
        (session.plan().stages.iter().any(|stage| stage.name == "texture_in"), sizes.iter().all(|&bytes| bytes > 0))
    };
    assert_eq!((numbers("exit"), numbers("entry"), numbers("both")), ((false, false), (true, true), (true, true)));
}
