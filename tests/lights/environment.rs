//! Environments: irradiance by nine spherical harmonics against a sum over all pixels, and occlusion.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use milkglass::internals::layout::{Buffers, ObjectParams};
use milkglass::internals::lighting::fresnel::{diffuse_external_exact, transmittance};
use milkglass::internals::lighting::sky;
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::prepare::material::dipoles;
use milkglass::internals::session::run::Session;
use milkglass::measure::reference::verify;
use milkglass::scene::{Light, Scene, Sky, Source};

use super::{irradiance, places, scene, sheets};

/// A scene lit by this environment alone.
fn under(mut scene: Scene, sky: Sky, occlusion: u32) -> Scene {
    scene.lights = vec![Light { source: Source::Environment { sky, occlusion }, shadows: true }];
    scene
}

fn white() -> Sky {
    Sky::new([5, 3], vec![[0.7; 3]; 15])
}

#[test]
fn a_white_environment_gives_the_hemisphere_of_the_boundary() {
    for eta in [1.0, 1.02, 1.3, 1.5, 2.5, 4.0] {
        let expected = 0.7 * PI * (1.0 - diffuse_external_exact(eta));
        for occlusion in [0, 64] {
            let ball = scene("sphere", &["object.0.detail=3", &format!("object.0.material.eta={eta}")]);
            for e in irradiance(&under(ball, white(), occlusion)) {
                assert!((e / expected - 1.0).abs().max_element() < 1e-4, "{eta}: {e} {expected}");
            }
        }
    }
}

#[test]
fn the_centres_of_pixels_shine_as_they_say_and_means_between_them() {
    let (width, height) = (6, 4);
    let sky = (0..width * height).map(|k: usize| [(k * k % 17) as f32, k as f32, 1.0]).collect::<Vec<_>>();
    let params = ObjectParams { sky: [width as u32, height as u32], ..ObjectParams::default() };
    let data = Buffers { sky: sky.clone(), object_params: vec![params], ..Buffers::default() };
    // Azimuth from -z towards x, polar angle from +y.
    let toward = |column: f64, row: f64| {
        let (a, t) = (TAU * (column + 0.5) / width as f64, PI * (row + 0.5) / height as f64);
        3.0 * DVec3::new(t.sin() * a.sin(), t.cos(), -t.sin() * a.cos())
    };
    let pixel = |column: usize, row: usize| DVec3::from_array(sky[row * width + column % width].map(f64::from));
    let near = |found: DVec3, expected: DVec3| assert!(found.distance(expected) < 1e-9, "{found}, not {expected}");
    for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let (x, y) = (column as f64, row as f64);
        near(sky::radiance(&data, toward(x, y)), pixel(column, row));
        let across = pixel(column, row).lerp(pixel(column + 1, row), 0.25);
        near(sky::radiance(&data, toward(x + 0.25, y)), across);
        if row + 1 < height {
            let below = pixel(column, row + 1).lerp(pixel(column + 1, row + 1), 0.25);
            near(sky::radiance(&data, toward(x + 0.25, y + 0.5)), across.midpoint(below));
        }
    }
    near(sky::radiance(&data, DVec3::new(0.01, 9.0, 0.02)).with_y(0.0).with_x(0.0), DVec3::Z);
}

/// Irradiance by a sum over all pixels, each divided into 4 x 4, for one index of refraction.
fn brute(sky: &Sky, normal: DVec3, eta: f64) -> DVec3 {
    let [width, height] = sky.size;
    let mut sum = DVec3::ZERO;
    for (row, i) in (0..height).flat_map(|row| (0..4).map(move |i| (row, i))) {
        let step = (sky.polar(row + 1) - sky.polar(row)) / 4.0;
        let top = sky.polar(row) + step * f64::from(i);
        let (t, angle) = (top + 0.5 * step, (top.cos() - (top + step).cos()) * TAU / f64::from(4 * width));
        for (column, j) in (0..width).flat_map(|column| (0..4).map(move |j| (column, j))) {
            let a = sky.azimuth(column) + TAU * (f64::from(j) + 0.5) / f64::from(4 * width);
            let cosine = normal.dot(DVec3::new(t.sin() * a.sin(), t.cos(), -t.sin() * a.cos()));
            if cosine > 0.0 {
                sum += sky.radiance(column, row) * (angle * cosine * transmittance(eta, cosine));
            }
        }
    }
    sum
}

/// The largest error over a ball of this index per channel, relative to the mean.
fn error_at(sky: &Sky, eta: [f64; 3]) -> f64 {
    let ball = scene("sphere", &["object.0.detail=2", &format!("object.0.material.eta={eta:?}")]);
    let found = irradiance(&under(ball.clone(), sky.clone(), 0));
    let at =
        |normal| DVec3::new(brute(sky, normal, eta[0]).x, brute(sky, normal, eta[1]).y, brute(sky, normal, eta[2]).z);
    let exact: Vec<DVec3> = places(&ball.objects[0].mesh).iter().map(|&(_, normal)| at(normal)).collect();
    let mean = exact.iter().sum::<DVec3>() / exact.len() as f64;
    let off = found.iter().zip(&exact).map(|(a, b)| ((*a - *b) / mean).abs().max_element());
    off.fold(0.0, f64::max)
}

fn error(sky: &Sky) -> f64 {
    error_at(sky, [1.4; 3])
}

#[test]
fn each_channel_enters_by_its_own_index() {
    // A gradient and a quadrupole, the same in all channels: nine harmonics are exact but for the pixels' size.
    let pixels = (0..32).flat_map(|row| {
        (0..64).map(move |column| {
            let (t, a) = (PI * (f64::from(row) + 0.5) / 32.0, TAU * (f64::from(column) + 0.5) / 64.0);
            let (x, y) = (t.sin() * a.cos(), t.cos());
            [(1.3 + 0.6 * x + 0.4 * y + 0.3 * x * y) as f32; 3]
        })
    });
    let sky = Sky::new([64, 32], pixels.collect());
    let off = error_at(&sky, [1.02, 1.5, 2.5]);
    assert!(off < 3e-3, "{off}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn smooth_environments_are_within_a_hundredth() {
    let light = "light.0={ type = \"environment\", image = \"builtin:sky\", rotation = 70 }";
    let built_in = scene("sphere", &[light]);
    let Source::Environment { sky, .. } = &built_in.lights[0].source else { panic!("an environment") };
    assert!(error(sky) < 0.01, "{}", error(sky));
    // A cubic gradient across, three times as bright on one side: nine harmonics cannot represent it exactly.
    let pixels = (0..32).flat_map(|row| {
        (0..64).map(move |column| {
            let (t, a) = (PI * (f64::from(row) + 0.5) / 32.0, TAU * (f64::from(column) + 0.5) / 64.0);
            let x = t.sin() * a.cos();
            [(1.0 + 0.3 * x + 0.2 * x * x * x) as f32, 1.0, (1.0 + 0.5 * t.cos()) as f32]
        })
    });
    let smooth = Sky::new([64, 32], pixels.collect());
    assert!(error(&smooth) < 0.01, "{}", error(&smooth));
    // One bright spot on black shows the error of nine harmonics.
    let mut spot = vec![[0.0; 3]; 64 * 32];
    spot[10 * 64 + 20] = [1000.0; 3];
    let sharp = error(&Sky::new([64, 32], spot));
    println!("one bright pixel on black: largest error {sharp:.2} of the mean irradiance");
    assert!(sharp > 0.05 && sharp < 1.0, "{sharp}");
}

#[test]
fn a_sun_has_its_direction_and_shows_once() {
    let place = 40 * 256 + 128 + 20;
    let (t, a) = (PI * 40.5 / 128.0, TAU * 20.5 / 256.0);
    let toward = DVec3::new(t.sin() * a.sin(), t.cos(), -t.sin() * a.cos());
    let mut pixels = vec![[0.6, 0.7, 0.9]; 256 * 128];
    pixels[place] = [9000.0, 8000.0, 7000.0];
    let sky = Sky::new([256, 128], pixels);
    let split = sky.clone().with_sun();
    let (direction, sun, _) = split.sun().expect("a sun");
    assert!(direction.distance(toward) < 1e-6, "{direction} {toward}");
    // What arrives is that of the image.
    let ball = scene("sphere", &["object.0.detail=1"]);
    let normals: Vec<DVec3> = places(&ball.objects[0].mesh).iter().map(|&(_, normal)| normal).collect();
    let exact: Vec<DVec3> = normals.iter().map(|&normal| brute(&sky, normal, 1.5)).collect();
    let mean = exact.iter().sum::<DVec3>() / exact.len() as f64;
    let off = |found: &[DVec3]| {
        found.iter().zip(&exact).map(|(a, b)| ((*a - *b) / mean).abs().max_element()).fold(0.0, f64::max)
    };
    let by_hand = |normal: &DVec3| {
        let cosine = normal.dot(direction).max(0.0);
        brute(&split, *normal, 1.5) + DVec3::from_array(sun) * (cosine * transmittance(1.5, cosine))
    };
    let by_hand = off(&normals.iter().map(by_hand).collect::<Vec<_>>());
    let found = |sky: &Sky| {
        let mut lit = under(ball.clone(), sky.clone(), 0);
        (lit.lights[0].shadows, lit.objects[0].material.eta) = (false, [1.5; 3]);
        off(&irradiance(&lit))
    };
    println!(
        "a sun: {by_hand:.1e} by hand, {:.1e} in a frame, {:.1e} as part of the image",
        found(&split),
        found(&sky)
    );
    assert!(by_hand < 5e-3 && found(&split) < 1e-2 && found(&sky) > 0.1);
    // And what is seen.
    let seen = |sky: &Sky| {
        let mut view = under(scene("sphere", &["object.0.detail=0", "camera.size=[64,64]"]), sky.clone(), 0);
        view.camera.position = 1000.0 * toward;
        (view.camera.target, view.camera.fov, view.camera.environment) = (2000.0 * toward, 10.0, true);
        let mut session = Session::new(&view, None, Options::default()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.state().data.radiance.iter().map(|pixel| DVec3::from_array(pixel.map(f64::from))).sum::<DVec3>()
    };
    // On black, too, where nothing but the sun is left to see.
    let mut black = vec![[0.0; 3]; 256 * 128];
    black[place] = [9000.0, 8000.0, 7000.0];
    for whole in [sky, Sky::new([256, 128], black)] {
        let ratio = seen(&whole.clone().with_sun()) / seen(&whole);
        assert!((ratio - 1.0).abs().max_element() < 0.03, "{ratio}");
    }
}

#[test]
fn rotation_turns_about_the_vertical() {
    // A bright patch in the middle of the image is at -z; turned by 90 degrees anticlockwise from above it is at -x.
    let mut pixels = vec![[0.0; 3]; 8 * 4];
    for (row, column) in [(1, 3), (1, 4), (2, 3), (2, 4)] {
        pixels[8 * row + column] = [1.0; 3];
    }
    for (rotation, toward) in [(0.0, -DVec3::Z), (90.0, -DVec3::X), (-90.0, DVec3::X), (180.0, DVec3::Z)] {
        let mut sky = Sky::new([8, 4], pixels.clone());
        sky.rotation = rotation;
        let ball = scene("sphere", &["object.0.detail=3"]);
        let found = irradiance(&under(ball.clone(), sky, 0));
        let sum: DVec3 = places(&ball.objects[0].mesh).iter().zip(&found).map(|((_, n), e)| *n * e.x).sum();
        assert!(sum.normalize().dot(toward) > 0.999, "{rotation}: {sum}");
    }
}

#[test]
fn what_is_hidden_does_not_arrive() {
    // The floor of a pit sees part of the sky, more of it the shallower the pit; a closed box sees none.
    let well = |depth: f64| {
        let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * depth);
        let corner = DVec3::new(-1.0, -1.0, 0.0);
        let walls = [[corner, y, z], [corner, z, x], [corner + x, z, y], [corner + y, x, z]];
        let floor = [corner, x, y];
        sheets(6, &[[floor].as_slice(), &walls].concat())
    };
    let lid = |depth: f64| {
        let corner = DVec3::new(-1.0, -1.0, depth);
        let mut all = well(depth);
        let top = sheets(6, &[[corner, DVec3::Y * 2.0, DVec3::X * 2.0]]);
        let first = all.positions.len() as u32;
        all.positions.extend(top.positions);
        all.triangles.extend(top.triangles.iter().map(|t| t.map(|v| v + first)));
        all.input_face = (0..all.triangles.len() as u32).collect();
        all
    };
    let floor = |mesh, occlusion| {
        let mut pit = scene("sphere", &["object.0.detail=0"]);
        pit.objects[0].mesh = mesh;
        let found = irradiance(&under(pit, white(), occlusion));
        found[..72].iter().map(|e| e.x).sum::<f64>() / 72.0
    };
    let (open, shallow, deep) = (floor(well(2.0), 0), floor(well(0.5), 256), floor(well(4.0), 256));
    assert!(deep < 0.1 * open && shallow > 0.4 * open && shallow < 0.95 * open, "{open} {shallow} {deep}");
    assert_eq!(floor(lid(1.0), 256), 0.0);
}

#[test]
fn a_black_environment_is_dark() {
    let ball = || scene("sphere", &["object.0.detail=1"]);
    let sky = Sky::new([4, 2], vec![[0.0; 3]; 8]);
    assert!(irradiance(&under(ball(), sky, 16)).iter().all(|e| *e == DVec3::ZERO));
    let mut ball = under(ball(), white(), 0);
    ball.objects[0].material.two_sided = true;
    let expected = 2.0 * 0.7 * PI * (1.0 - diffuse_external_exact(ball.objects[0].material.eta[0]));
    assert!(irradiance(&ball).iter().all(|e| (e.x / expected - 1.0).abs() < 1e-4));
}

#[test]
fn a_wide_plane_in_a_white_environment_gives_back_what_the_half_space_does() {
    for preset in ["marble", "ketchup", "wholemilk"] {
        let mut flat = scene("sphere", &["object.0.detail=0", &format!("object.0.material.preset={preset}")]);
        let material = &flat.objects[0].material;
        let dipoles = dipoles(material, 1.0);
        // The plane is 1,000 times as wide as the height of the highest channel's virtual source.
        let half = 500.0 * dipoles.iter().map(|dipole| dipole.z_virtual).fold(0.0, f64::max);
        let expected = dipoles.map(|dipole| {
            let source = |z: f64| (-dipole.sigma * z).exp();
            2.0 * PI * dipole.strength * (source(dipole.z_real) + source(dipole.z_virtual))
        });
        flat.objects[0].mesh =
            sheets(32, &[[DVec3::new(-half, -half, 0.0), DVec3::X * 2.0 * half, DVec3::Y * 2.0 * half]]);
        let flat = under(flat, white(), 0);
        let options = Options { goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(&flat, None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let places = session.prepared().places(0);
        let face = places[2 * (16 * 32 + 16)];
        let data = &session.state().data;
        for (c, expected) in expected.into_iter().enumerate() {
            let share = f64::from(data.radiosity[face][c]) / f64::from(data.irradiance[face][c]);
            assert!((share / expected - 1.0).abs() < 1e-3, "{preset}, channel {c}: {share}, not {expected}");
        }
    }
}

#[test]
fn in_a_white_environment_any_mesh_is_as_near_to_brute_force_as_asked() {
    for name in ["lotus", "slab"] {
        let detail = if name == "lotus" { "object.0.detail=40" } else { "object.0.detail=12" };
        let white = under(scene(name, &[detail]), white(), 16);
        let options = Options { goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(&white, None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let worst = verify(&mut session, 200, 1).unwrap().iter().map(|norms| norms.l2).fold(0.0, f64::max);
        assert!(worst > 0.0 && worst < 1e-3, "{name}: {worst}");
    }
}
