//! Single stages against their definitions: sums over all faces, means over vertices, integrals that are known, and
//! shading of a ball.

use glam::DVec3;
use milkglass::internals::dipole::form_factor::{Distance, edge::edge_form, gauss::legendre};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::layout::{Buffers, Query};
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::shading::balls::{ANGLES, angle};
use milkglass::internals::shading::{cdrf_values, smooth_curvature};
use milkglass::internals::state::{Scope, State};
use milkglass::internals::view::aov::{Layer, Samples};
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::interpret::stage::Interpreter;
use milkglass::scene::Scene;
use std::f64::consts::PI;

fn drawn(name: &str, sets: &[&str], transport: ShadingMethod, goal: Goal) -> Session {
    let sets: Vec<String> = ["camera.size=[24, 20]"].iter().chain(sets).map(ToString::to_string).collect();
    let scene = Scene::load_with(name, &sets).unwrap();
    let mut session = Session::new(&scene, None, Options { transport, goal, ..Options::default() }).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn corners(data: &Buffers, face: usize) -> [DVec3; 3] {
    data.triangles[face].map(|v| wide(data.positions[v as usize]))
}

/// A coloured light, so that no channel passes for another.
const RED: &str = "light=[{ type = 'directional', direction = [1, 2, 3], irradiance = [3, 1, 0.4] }]";

/// The kernel takes four faces at once, and a ball's vertices have five or six.
#[test]
fn infinite_radiosity_makes_no_nan_at_vertices() {
    let scene = Scene::load_with("sphere", &["object.0.detail=1".into(), "camera.size=[24, 20]".into()]).unwrap();
    let Fixture { mut state, steps, .. } = Fixture::of_scene("ball", &scene).unwrap();
    let at = steps.iter().position(|step| step.stage.name == "average").unwrap();
    steps[..at].iter().for_each(|step| step.reference(&mut state));
    let bright = state.data.corners[state.data.corner_starts[1] as usize - 1] as usize;
    state.data.radiosity[bright][0] = f32::INFINITY;
    let leaf = state.data.leaves[bright] as usize;
    for area in [state.data.clusters[leaf].area, 0.0] {
        state.data.clusters[leaf].area = area;
        let [mut reference, mut kernel] = [state.clone(), state.clone()];
        steps[at].reference(&mut reference);
        Interpreter::default().run(&state, steps[at], false).unwrap().write(&mut kernel);
        for found in [reference, kernel] {
            let infinite = |vertex: usize| area > 0.0 && state.data.triangles[bright].contains(&(vertex as u32));
            for (vertex, mean) in found.data.vertex_radiosity.iter().enumerate() {
                let [red, rest @ ..] = *mean;
                assert!(rest.iter().all(|value| value.is_finite()), "{vertex}: {mean:?}");
                assert_eq!(red == f32::INFINITY, infinite(vertex), "{vertex}: {mean:?}");
                assert!(!red.is_nan(), "{vertex}: {mean:?}");
            }
        }
    }
}

#[test]
fn brute_force_is_the_sum_over_all_faces() {
    for (name, detail) in [("sphere", 2), ("slab", 8), ("lotus", 16)] {
        let detail = format!("object.0.detail={detail}");
        let session = drawn(name, &[&detail, RED], ShadingMethod::Brute, Goal::Radiosity);
        let (data, rule) = (&session.state().data, legendre(24));
        let dipoles = [0, 1, 2].map(|c| Dipole::of(&data.object_params[0], c));
        let count = data.triangles.len();
        let (mut square, mut error) = (DVec3::ZERO, DVec3::ZERO);
        for receiver in (0..count).step_by(7) {
            let place = corners(data, receiver).iter().sum::<DVec3>() / 3.0;
            let factor = |face: usize, c: usize| {
                edge_form(&corners(data, face), data.triangles[face], place, &dipoles[c], Distance::Radial, &rule)
            };
            let each = |face: usize| {
                wide(data.irradiance[face]) * DVec3::new(factor(face, 0), factor(face, 1), factor(face, 2))
            };
            let expected: DVec3 = (0..count).map(each).sum();
            error += (wide(data.radiosity[receiver]) - expected).powf(2.0);
            square += expected * expected;
        }
        // If single samples began at half their distance, the error on a ball would be 1e-4.
        let error = (error / square).max_element().sqrt();
        assert!(error < 7e-5, "{name}: {error}");
    }
}

#[test]
fn vertices_have_the_mean_of_the_faces_around_them() {
    let sets = ["object.0.detail=16", RED, "transport.receivers=faces"];
    let session = drawn("lotus", &sets, ShadingMethod::default(), Goal::Picture);
    let data = &session.state().data;
    let mut sums = vec![(DVec3::ZERO, 0.0); data.positions.len()];
    for face in 0..data.triangles.len() {
        let [a, b, c] = corners(data, face);
        let area = (b - a).cross(c - a).length();
        for v in data.triangles[face] {
            let sum = &mut sums[v as usize];
            (sum.0, sum.1) = (sum.0 + area * wide(data.radiosity[face]), sum.1 + area);
        }
    }
    assert!(data.vertex_radiosity.len() == sums.len() && !sums.is_empty());
    for (found, (sum, area)) in data.vertex_radiosity.iter().zip(sums) {
        let expected = sum / area;
        assert!(wide(*found).distance(expected) < 1e-5 * expected.length() + 1e-9, "{found:?} {expected}");
    }
}

#[test]
fn curvature_adds_up_to_that_of_the_whole_surface() {
    for (name, detail, handles) in [("sphere", 3, 0.0), ("torus", 40, 1.0)] {
        let detail = format!("object.0.detail={detail}");
        let session = drawn(name, &[&detail], ShadingMethod::Cdrf, Goal::Picture);
        let data = &session.state().data;
        let area: f64 = (0..data.triangles.len())
            .map(|face| corners(data, face))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
            .sum();
        let whole = data.curvature_sums[0];
        // Gauss and Bonnet: 4 pi for each ball, less 4 pi for each handle.
        assert!((f64::from(whole.gaussian) - 4.0 * PI * (1.0 - handles)).abs() < 1e-3, "{name}: {}", whole.gaussian);
        assert!((f64::from(whole.area) / area - 1.0).abs() < 1e-4, "{name}: {} {area}", whole.area);
    }
}

#[test]
fn smoothing_over_a_small_ball_keeps_what_varies_slowly() {
    // Edges of 0.4 mm; the curvature of the torus changes over several millimetres.
    let sets = ["object.0.detail=96", "object.0.size=20", "object.0.material.curvature_radius=1"];
    let session = drawn("torus", &sets, ShadingMethod::Cdrf, Goal::Picture);
    let data = &session.state().data;
    let (mut apart, mut spread, mut mean) = (0.0, 0.0, 0.0);
    for (v, own) in data.curvature.iter().enumerate() {
        let (own, smooth) = (f64::from(own.kappa), f64::from(smooth_curvature::kappa(data, v)));
        apart += (smooth - own).powi(2);
        (spread, mean) = (spread + own * own, mean + own);
    }
    let count = data.curvature.len() as f64;
    let spread = spread - mean * mean / count;
    assert!(spread > 0.0 && apart < 0.01 * spread, "{apart} of {spread}");
}

#[test]
fn a_translucent_or_opaque_ball_under_lamberts_cosine_is_the_cosine() {
    let sun =
        "light=[{ type = 'directional', direction = [2.0, 1.0, 0.1], irradiance = [3, 1, 0.4], shadows = false }]";
    let opaque = "object.0.material={ opaque = true, albedo = [0.5, 0.25, 0.1], eta = 1 }";
    for material in ["object.0.material.eta=1", opaque] {
        let sets = ["object.0.detail=5", material, sun];
        let mut session = drawn("sphere", &sets, ShadingMethod::Lambert, Goal::Picture);
        let picture = session.picture().unwrap();
        let data = &session.state().data;
        let toward = DVec3::new(2.0, 1.0, 0.1).normalize();
        let translucent = [0, 1, 2].map(|c| Dipole::of(&data.object_params[0], c).total());
        let diffuse = if material == opaque { [0.5, 0.25, 0.1] } else { translucent };
        let (mut lit, mut dark) = (0, 0);
        for (pixel, hit) in picture.pixels.iter().zip(&data.hits).filter(|(_, hit)| hit.face != u32::MAX) {
            // The ball is about the origin, so a point of it is its normal.
            let [a, b, c] = corners(data, hit.face as usize);
            let point = (1.0 - f64::from(hit.u) - f64::from(hit.v)) * a + f64::from(hit.u) * b + f64::from(hit.v) * c;
            let cosine = point.normalize().dot(toward).max(0.0);
            for c in 0..3 {
                let expected = diffuse[c] / PI * cosine * [3.0, 1.0, 0.4][c];
                let found = f64::from(pixel[c]);
                assert!((found - expected).abs() < 2e-3 * [3.0, 1.0, 0.4][c], "{c} {cosine}: {found} {expected}");
            }
            (lit, dark) = if cosine > 0.0 { (lit + 1, dark) } else { (lit, dark + 1) };
        }
        assert!(lit > 50 && dark > 3, "{lit} {dark}");
    }
}

#[test]
fn values_of_the_cdrf_are_those_of_its_two_arguments() {
    // As sigma tends to 0: the cosine itself; far beyond pi: the mean of max(cos, 0) over the circle.
    let query = |cosine: f32, sigma: f32| Query { a: [cosine, sigma, 0.0], ..Query::default() };
    let mut state = State::default();
    state.data.queries = vec![query(0.8, 1e-4), query(-0.6, 1e-4), query(0.8, 9.0), query(-0.6, 9.0)];
    (cdrf_values::STAGE.cpu)(&mut state, Scope::SCENE);
    for (found, expected) in state.data.answers.iter().zip([0.8, 0.0, 1.0 / PI, 1.0 / PI]) {
        assert!((f64::from(found[0]) - expected).abs() < 1e-4, "{found:?} {expected}");
    }
}

#[test]
fn angles_are_the_midpoints_of_equal_parts() {
    for k in 0..ANGLES {
        assert!((angle(k) + angle(ANGLES - 1 - k) - PI).abs() < 1e-12);
        assert!(k == 0 || (angle(k) - angle(k - 1) - PI / ANGLES as f64).abs() < 1e-12);
    }
}

#[test]
fn layers_of_a_file_keep_their_channels_apart() {
    let layer = Layer::vector("light", ["R", "G", "B"], &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let expected = [("R", vec![1.0, 4.0]), ("G", vec![2.0, 5.0]), ("B", vec![3.0, 6.0])];
    for ((name, samples), (expected, values)) in layer.channels.iter().zip(expected) {
        assert!(*name == expected && matches!(samples, Samples::Float(found) if *found == values), "{name}");
    }
}

#[test]
fn an_environment_behind_everything_has_its_own_radiance() {
    // The camera looks past the ball; its scale of radiance is not 1.
    for radiance in [0.25, 40.0] {
        let sky = format!("light=[{{ type = 'environment', radiance = {radiance} }}]");
        let view = ["camera.background=environment", "camera.target=[500, 0, 0]", &sky];
        let mut session = drawn("sphere", &view, ShadingMethod::Lambert, Goal::Picture);
        let pixels = session.picture().unwrap().pixels;
        assert!(pixels.iter().flatten().all(|&x| (f64::from(x) / radiance - 1.0).abs() < 1e-5), "{:?}", pixels[0]);
    }
}

#[test]
fn the_second_object_is_deformed_as_if_it_were_alone() {
    let other = |number: usize| {
        let deform = "[{ type = 'twist', angle = 100 }, { type = 'bend', angle = 40 }]";
        format!(
            "object.{number}={{ shape = 'torus', detail = 12, size = 9, position = [40, 5, 0], material = {{ preset = 'marble' }}, deform = {deform} }}"
        )
    };
    let places = |sets: &[&str], number: usize| {
        let session = drawn("sphere", sets, ShadingMethod::default(), Goal::Radiosity);
        let params = session.state().data.object_params[number];
        let own = params.first_vertex as usize..(params.first_vertex + params.vertices) as usize;
        let outside = |p: &[f32; 3]| session.units().outside(wide(*p));
        session.state().data.in_scene()[own].iter().map(outside).collect::<Vec<_>>()
    };
    let (alone, beside) = (places(&[&other(0)], 0), places(&["object.0.detail=3", &other(1)], 1));
    assert!(alone.len() == beside.len() && alone.len() > 50, "{} {}", alone.len(), beside.len());
    for (a, b) in alone.iter().zip(&beside) {
        assert!(a.distance(*b) < 1e-4, "{a} {b}");
    }
}

#[test]
fn fitted_planes_are_those_of_the_vertices_around_each_counted_once() {
    let deform = "object.0.deform=[{ type = 'noise', amplitude = 1, scale = 6 }]";
    let sets =
        ["object.0.shape=sphere", "object.0.size=20", "object.0.detail=3", "object.0.rotation=[0, 0, 0]", deform];
    let session = drawn("slab-layers", &sets, ShadingMethod::None, Goal::Picture);
    let data = &session.state().data;
    let radius = f64::from(data.object_params[0].fit_radius);
    let mut checked = 0;
    for (v, &[x, y, z, height]) in data.planes.iter().enumerate() {
        let (here, normal) = (wide(data.positions[v]), wide([x, y, z]));
        let points: Vec<DVec3> = data.positions.iter().map(|p| wide(*p) - here).collect();
        let edge = points.iter().any(|p| (p.length() / radius - 1.0).abs() < 1e-5);
        let near: Vec<DVec3> = points.into_iter().filter(|p| p.length() <= radius).collect();
        let center = near.iter().sum::<DVec3>() / near.len() as f64;
        let spread = |a: DVec3, b: DVec3| {
            near.iter().map(|p| (*p - center).dot(a) * (*p - center).dot(b)).sum::<f64>() / near.len() as f64
        };
        // Moments along the normal, and the least and largest across it.
        let (u, w) = normal.any_orthonormal_pair();
        let (uu, ww, uw) = (spread(u, u), spread(w, w), spread(u, w));
        let root = (0.25 * (uu - ww).powi(2) + uw * uw).sqrt();
        let [least, middle, most] = [spread(normal, normal), 0.5 * (uu + ww) - root, 0.5 * (uu + ww) + root];
        let upright = normal.dot(wide(data.normals[v]));
        if edge || least > 0.2 * middle || middle < 0.1 * most || upright < 0.85 {
            continue;
        }
        // The normal is a principal axis, and the plane goes through the centroid.
        let off = spread(normal, u).hypot(spread(normal, w));
        assert!(off < 2e-4 * (uu + ww), "{v}: {off} of {}", uu + ww);
        assert!((f64::from(height) - center.dot(normal)).abs() < 1e-4 * radius, "{v}: {height}");
        checked += 1;
    }
    assert!(checked > 300, "{checked} of {}", data.planes.len());
}
