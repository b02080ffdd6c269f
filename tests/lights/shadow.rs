//! Shadows: convex objects have none at any scale; others have those of a ray caster in `f64`.

use glam::DVec3;
use milkglass::scene::{Light, Mesh, Scene};

use super::{irradiance, mesh, places, scene, sheets, unshadowed};

/// A scene of this mesh under these lights.
fn of(mesh: Mesh, lights: Vec<Light>) -> Scene {
    let mut scene = scene("sphere", &["object.0.detail=0"]);
    (scene.objects[0].mesh, scene.lights) = (mesh, lights);
    scene
}

fn sun(x: f64, y: f64, z: f64) -> Light {
    Light::directional(DVec3::new(x, y, z).normalize(), [1.0; 3])
}

/// Equal to the last bit, except where light is so grazing that rounding decides whether a face is turned away from it.
fn same(found: &[DVec3], expected: &[DVec3], what: &str) {
    let most = expected.iter().map(|e| e.x).fold(0.0, f64::max);
    for (face, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(a == b || b.x < 1e-6 * most, "{what}: face {face} has {a}, not {b}; the brightest {most}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn convex_things_do_not_shadow_themselves_at_any_scale() {
    for (detail, factor, offset) in [(7, 1.0, 0.0), (5, 1e-6, 0.0), (5, 1e6, 0.0), (6, 1.0, 1e5), (4, 1e-6, 3.0)] {
        let mut ball = scene("sphere", &[&format!("object.0.detail={detail}")]);
        for position in &mut ball.objects[0].mesh.positions {
            *position = (*position + DVec3::new(1.0, -2.0, 0.7) * offset) * factor;
        }
        let lamp = (DVec3::new(5.1, 0.3, 0.2) + DVec3::new(1.0, -2.0, 0.7) * offset) * factor;
        ball.lights = vec![sun(0.3, -0.4, 0.1), sun(1.0, 0.0, 0.0), Light::point(lamp, [factor * factor; 3])];
        let (found, expected) = (irradiance(&ball), unshadowed(&ball));
        same(&found, &expected, &format!("detail {detail}, scale {factor}, offset {offset}"));
        assert!(found.iter().any(|e| e.x > 0.0));
    }
}

#[test]
fn a_slab_in_grazing_light_is_lit_all_over() {
    for height in [0.1, 1e-3, 1e-5, 1e-7] {
        let mut slab = scene("slab", &["object.0.detail=40"]);
        slab.lights = vec![sun(0.8, 0.6, height), sun(0.123, -0.9, height)];
        assert!(irradiance(&slab) == unshadowed(&slab), "{height}");
    }
}

#[test]
fn coincident_sheets_do_not_shadow_each_other() {
    let (x, y) = (DVec3::X * 3.0, DVec3::Y * 2.0);
    let corner = DVec3::new(0.1, 0.2, 0.3);
    let same = sheets(7, &[[corner, x, y], [corner, x, y]]);
    let opposite = sheets(7, &[[corner, x, y], [corner, y, x]]);
    for sheet in [same, opposite] {
        let scene = of(sheet, vec![sun(0.2, 0.3, 1.0), sun(0.9, 0.1, -0.02)]);
        assert!(irradiance(&scene) == unshadowed(&scene));
    }
    // A sheet above casts a shadow, however near it is.
    for gap in [1e-1, 1e-4, 1e-5] {
        let above = corner + DVec3::Z * gap;
        let scene = of(sheets(7, &[[corner, x, y], [above, x, y]]), vec![sun(0.0, 0.0, 1.0)]);
        let found = irradiance(&scene);
        assert!(found[..98].iter().all(|e| e.x == 0.0) && found[98..].iter().all(|e| e.x > 0.9), "{gap}");
    }
}

#[test]
fn a_lamp_in_a_surface_lights_what_it_sees() {
    // A lamp in the floor and a wall at its edge: both lit as without shadows. A lid over the lamp shades the wall's
    // top.
    let floor = [DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0];
    let wall = [DVec3::new(1.0, -1.0, 0.0), DVec3::Z, DVec3::Y * 2.0];
    let lid = [DVec3::new(-0.5, -0.5, 0.01), DVec3::X, DVec3::Y];
    for lamp in [DVec3::ZERO, DVec3::new(0.1, 0.03, 0.0), DVec3::new(1.0 / 3.0, 0.25, 0.0)] {
        let lamp = vec![Light::point(lamp, [1.0; 3])];
        let room = of(sheets(8, &[floor, wall]), lamp.clone());
        assert!(irradiance(&room) == unshadowed(&room));
        let lit = irradiance(&of(sheets(8, &[floor, wall, lid]), lamp));
        assert!(lit[128 + 64..256].iter().any(|e| e.x == 0.0), "the wall's top is hidden");
    }
}

/// Whether a ray is certainly blocked, and whether it may be, by barycentric coordinates with a margin.
fn cast(mesh: &Mesh, face: usize, origin: DVec3, direction: DVec3, far: bool) -> (bool, bool) {
    let (mut certain, mut possible) = (false, false);
    for other in (0..mesh.triangles.len()).filter(|&other| other != face) {
        let [a, b, c] = mesh.corners(other).unwrap();
        let (e1, e2) = (b - a, c - a);
        let p = direction.cross(e2);
        let determinant = e1.dot(p);
        let s = origin - a;
        let q = s.cross(e1);
        let (u, v, t) = (s.dot(p) / determinant, direction.dot(q) / determinant, e2.dot(q) / determinant);
        let least = u.min(v).min(1.0 - u - v).min(t * 100.0);
        let inner = if far { least } else { least.min((1.0 - t) * 100.0) };
        certain |= inner > 1e-3;
        possible |= inner > -1e-3;
    }
    (certain, possible)
}

#[test]
fn shadows_are_those_of_a_ray_caster() {
    let mut lotus = scene("lotus", &["object.0.detail=32"]);
    lotus.lights.truncate(0);
    let mesh = &lotus.objects[0].mesh;
    let (mut shadowed, mut lit, mut close) = (0, 0, 0);
    for (light, place, far) in [
        (Light::point(DVec3::new(0.0, -2.0, 0.0), [1.0; 3]), DVec3::new(0.0, -2.0, 0.0), false),
        (sun(-0.5, 0.8, -0.7), DVec3::new(-0.5, 0.8, -0.7), true),
        (sun(1.0, 0.1, 0.0), DVec3::new(1.0, 0.1, 0.0), true),
    ] {
        let found = irradiance(&Scene { lights: vec![light], ..lotus.clone() });
        for (face, &(center, normal)) in places(mesh).iter().enumerate() {
            let direction = if far { place } else { place - center };
            if normal.dot(direction.normalize()) < 1e-3 {
                continue;
            }
            match (cast(mesh, face, center, direction, far), found[face].x > 0.0) {
                ((true, _), true) => panic!("face {face} should be in shadow of {place}"),
                ((_, false), false) => panic!("face {face} should be lit by {place}"),
                ((true, _), false) => shadowed += 1,
                ((_, false), true) => lit += 1,
                _ => close += 1,
            }
        }
    }
    assert!(shadowed > 300 && lit > 300 && close < 100, "{shadowed} {lit} {close}");
}

#[test]
fn a_light_in_a_cavity_lights_its_walls_and_nothing_else() {
    let ball = scene("sphere", &["object.0.detail=3"]).objects[0].mesh.clone();
    let mut positions = ball.positions.clone();
    positions.extend(ball.positions.iter().map(|&p| p * 0.5));
    let count = ball.positions.len() as u32;
    let inner = ball.triangles.iter().map(|&[a, b, c]| [a + count, c + count, b + count]);
    let triangles: Vec<[u32; 3]> = ball.triangles.iter().copied().chain(inner).collect();
    let hollow = mesh(positions, triangles);
    let outer = ball.triangles.len();
    let inside = |place: DVec3| hollow.first_inside(&[place]).is_some();
    assert!(!inside(DVec3::ZERO) && inside(DVec3::X * 3.5) && !inside(DVec3::X * 5.5) && !inside(DVec3::X * 2.0));
    let lamp = |x: f64| vec![Light::point(DVec3::new(x, 0.1, 0.2), [1.0; 3])];
    let found = irradiance(&of(hollow.clone(), lamp(0.3)));
    assert!(found[..outer].iter().all(|e| e.x == 0.0) && found[outer..].iter().all(|e| e.x > 0.0));
    let found = irradiance(&of(hollow, lamp(9.0)));
    assert!(found[..outer].iter().any(|e| e.x > 0.0) && found[outer..].iter().all(|e| e.x == 0.0));
}

#[test]
fn both_sides_receive_where_the_material_says_so() {
    let mut ball = scene("sphere", &["object.0.detail=3", "object.0.material.two_sided=true"]);
    ball.lights = vec![Light::point(DVec3::new(0.5, 1.0, 0.0), [1.0; 3])];
    let from_inside = irradiance(&ball);
    assert!(from_inside.iter().all(|e| e.x > 0.0), "every wall sees the lamp");
    ball.lights = vec![sun(0.0, 0.0, 1.0)];
    let (shadowed, through) = (irradiance(&ball), unshadowed(&ball));
    for (face, (_, normal)) in places(&ball.objects[0].mesh).into_iter().enumerate() {
        if normal.z > 1e-6 {
            assert!(shadowed[face].x > 0.0, "the front is lit");
        } else if normal.z < -1e-6 {
            assert!(shadowed[face].x == 0.0 && through[face].x > 0.0, "the near half hides the far one");
        }
    }
}

#[test]
fn thousands_of_lights_shine() {
    let mut ball = scene("sphere", &["object.0.detail=2"]);
    let angle = |i: usize| 2.4 * i as f64;
    let y = |i: usize| 1.0 - 2.0 * (i as f64 + 0.5) / 3000.0;
    ball.lights = (0..3000).map(|i| sun(angle(i).cos(), y(i), angle(i).sin())).collect();
    assert!(irradiance(&ball) == unshadowed(&ball));
}
