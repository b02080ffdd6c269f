//! Diffusion under a texture, in a wall round a cavity, and on triangles that were subdivided at a shadow's border.

use milkglass::internals::layout::BUFFER_IDS;
use milkglass::internals::pipeline::plan::Change;
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use super::diffusion::{dense, off, options, scene};
use crate::devices;

/// Solves a scene on each device and holds it to the dense system of its triangles.
fn held_to_the_dense_system(scene: &Scene, look: impl Fn(&Session)) {
    devices::on_devices(|device| {
        let mut session = Session::new(scene, Some(device), options()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.fetch(BUFFER_IDS).unwrap();
        let data = &session.state().data;
        for c in 0..3 {
            let error = off(data, c, &dense(data, c));
            println!("{} triangles, channel {c}: {error:.1e}", data.triangles.len());
            assert!(error < 1e-3, "channel {c}: {error:.1e}");
        }
        look(&session);
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_texture_at_the_entry_dims_what_is_deposited() {
    let sets = ["object.0.detail=2", "transport.tolerance=1e-3"];
    let plain = {
        let mut session = Session::new(&scene("sphere", &sets), None, options()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.state().data.clone()
    };
    let tiles = ["object.0.material.texture=builtin:tiles", "object.0.material.texture_on=entry"];
    held_to_the_dense_system(&scene("sphere", &[&sets[..], &tiles].concat()), |session| {
        let data = &session.state().data;
        let mut dimmed = 0;
        for (face, (one, other)) in data.deposits.iter().zip(&plain.deposits).enumerate() {
            for c in 0..3 {
                // The same share of less light, in the same place.
                let (now, before) = (data.irradiance[face][c], plain.irradiance[face][c]);
                let (left, right) = (one.light[c] * before, other.light[c] * now);
                assert!((left - right).abs() <= 1e-4 * right.abs(), "{face} {c}: {left} {right}");
                dimmed += usize::from(now < 0.9 * before);
            }
        }
        assert!(dimmed > 100, "{dimmed}");
    });
}

#[test]
fn a_source_term_much_larger_than_the_solution_is_no_excuse() {
    let clear = "object.0.material={ sigma_s_prime = [0.3, 0.6, 1], sigma_a = 0, eta = 1.4 }";
    let sets = ["object.0.detail=2", "object.0.size=200", clear, "transport.tolerance=1e-3"];
    held_to_the_dense_system(&scene("sphere", &sets), |_| ());
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_wall_round_a_cavity_has_two_sides() {
    // Nothing is absorbed: what collides leaves, by the outer side or into the cavity.
    let clear = "object.0.material={ sigma_s_prime = [1, 2, 4], sigma_a = 0, eta = 1.4 }";
    let mut shell = scene("sphere", &["object.0.detail=2", "object.0.size=20", clear, "transport.tolerance=1e-3"]);
    let mesh = &mut shell.objects[0].mesh;
    let count = mesh.positions.len() as u32;
    mesh.positions.extend(mesh.positions.clone().iter().map(|place| *place * 0.7));
    mesh.triangles.extend(mesh.triangles.clone().iter().map(|[a, b, c]| [a + count, c + count, b + count]));
    mesh.input_face = (0..mesh.triangles.len() as u32).collect();
    held_to_the_dense_system(&shell, |session| {
        let faces = session.state().data.triangles.len();
        let data = &session.state().data;
        for c in 0..3 {
            let (mut inner, mut left, mut deposited) = (0.0, 0.0, 0.0);
            for face in 0..faces {
                let cluster = &data.clusters[data.leaves[face] as usize];
                let light = f64::from(cluster.area) * f64::from(data.solution[face][c]);
                let middle: f32 = cluster.center.iter().zip(&cluster.normal).map(|(x, n)| x * n).sum();
                inner += if middle < 0.0 { light } else { 0.0 };
                left += light;
                deposited += f64::from(cluster.area) * f64::from(data.deposits[face].light[c]);
            }
            println!("channel {c}: {:.3} of {:.3} leaves, {:.3} of it into the cavity", left, deposited, inner / left);
            assert!((left / deposited - 1.0).abs() < 1e-2, "channel {c}: {left} of {deposited}");
            assert!(inner > 0.05 * left && inner < 0.5 * left, "channel {c}: {inner} of {left}");
        }
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn triangles_are_subdivided_at_borders_of_shadows() {
    let plate = "object.1={ shape = 'slab', detail = 4, size = 14, position = [3, 4, 12], rotation = [0, 0, 33], \
                 material = { opaque = true } }";
    let light = "light.0={ type = 'directional', direction = [0.2, 0.3, 1], irradiance = 3 }";
    let shadowed = |levels: u32| {
        let levels = format!("transport.subdivide={levels}");
        scene("slab", &["object.0.detail=10", "object.0.size=20", light, plate, "transport.tolerance=1e-3", &levels])
    };
    let rows = |levels: u32| {
        let mut session = Session::new(&shadowed(levels), None, options()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let rows = session.faces().unwrap();
        (session.state().data.triangles.len(), rows)
    };
    let ((coarse, before), (middle, some), (fine, exact)) = (rows(0), rows(2), rows(4));
    assert!(coarse < middle && middle < fine, "{coarse} {middle} {fine}");
    assert!(before.len() == some.len() && some.len() == exact.len());
    // Two levels come nearer to what four give.
    let apart = |rows: &[milkglass::FaceLight]| {
        let own = rows.iter().zip(&exact).filter(|(row, _)| row.object == 0);
        own.map(|(a, b)| a.area * (a.radiosity[0] - b.radiosity[0]).powi(2)).sum::<f64>()
    };
    println!("{coarse}, {middle}, {fine} triangles: {:.1e}, {:.1e}", apart(&before), apart(&some));
    assert!(apart(&some) < 0.3 * apart(&before), "{} {}", apart(&before), apart(&some));
}
