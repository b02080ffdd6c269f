//! Triangles subdivided where a shadow border crosses them.

use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::internals::session::subdivide::subdivide;
use milkglass::internals::state::wide;
use milkglass::measure::estimate::Quality;
use milkglass::measure::reference::at;
use milkglass::scene::Scene;

fn scene(sets: &[&str]) -> Scene {
    let mut all =
        vec!["object.0.detail=12", "light.0={ type = 'directional', direction = [0.2, 0.3, 1], irradiance = 3 }"];
    all.push("object.0.size=20");
    // Triangles stay, though they are long against the mean free path.
    all.push("transport.receivers='faces'");
    // A slanted plate above part of the slab: its shadow border crosses triangles in all directions.
    all.push(
        "object.1={ shape = 'slab', detail = 4, size = 14, position = [3, 4, 12], rotation = [0, 0, 33], \
         material = { opaque = true } }",
    );
    all.extend(sets);
    Scene::load_with("slab", &all.into_iter().map(String::from).collect::<Vec<_>>()).unwrap()
}

fn options() -> Options {
    Options { goal: Goal::Radiosity, ..Options::default() }
}

/// Radiosity at the centroids of the slab's triangles before subdivision, and the number of triangles after it.
fn solved(scene: &Scene) -> (Vec<[f64; 3]>, usize) {
    let mut session = Session::new(scene, None, options()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session.fetch(&[BufferId::radiosity]).unwrap();
    let (places, light) = (session.prepared().places(0), session.units().light);
    let at = |part: usize| session.state().data.radiosity[places[part]].map(|x| f64::from(x) * light);
    let values = match session.parts().first() {
        Some(parts) => parts.middle.iter().map(|&part| at(part as usize)).collect(),
        None => (0..places.len()).map(at).collect(),
    };
    (values, places.len())
}

/// The same by brute force, with every triangle of the slab divided into sixteen.
fn exact(scene: &Scene) -> Vec<[f64; 3]> {
    let mut fine = scene.clone();
    fine.transport.subdivide = 0;
    for _ in 0..2 {
        fine.objects[0].mesh = fine.objects[0].mesh.split(|_| true).0;
    }
    let mut session = Session::new(&fine, None, options()).unwrap();
    session.prepare_light();
    let alone = session.state().alone(0);
    // Part 15 of 16 is the centre of the centre part.
    let places = session.prepared().places(0);
    let centers: Vec<_> = (0..scene.objects[0].mesh.triangles.len())
        .map(|face| wide(alone.data.clusters[alone.data.leaves[places[16 * face + 15]] as usize].center))
        .collect();
    let light = session.units().light;
    at(&alone, &centers).into_iter().map(|value| value.map(|x| x * light)).collect()
}

/// Area-weighted relative L2 error over the slab's triangles, in the worst channel.
fn error(scene: &Scene, values: &[[f64; 3]], exact: &[[f64; 3]]) -> f64 {
    let mesh = &scene.objects[0].mesh;
    let area = |face: usize| mesh.corners(face).map_or(0.0, |[a, b, c]| 0.5 * (b - a).cross(c - a).length());
    let relative = |c: usize| {
        let sum = |f: &dyn Fn(usize) -> f64| (0..values.len()).map(|k| area(k) * f(k) * f(k)).sum::<f64>();
        (sum(&|k| values[k][c] - exact[k][c]) / sum(&|k| exact[k][c])).sqrt()
    };
    (0..3).map(relative).fold(0.0, f64::max)
}

#[test]
fn parts_are_shaded_as_the_whole_triangle() {
    let sets = ["object.0.shape='sphere'", "object.0.detail=1", "transport.subdivide=2"];
    let scene = scene(&sets);
    let (fine, parts) = subdivide(&scene, options(), false).unwrap().expect("a border of a shadow");
    let (mesh, whole) = (&fine.objects[0].mesh, &scene.objects[0].mesh);
    let (normals, around) = (mesh.normals.as_ref().expect("normals"), whole.vertex_normals());
    assert!(mesh.triangles.len() > 2 * whole.triangles.len());
    assert_eq!(normals[..around.len()], around);
    // Those of the parts themselves lie along the triangle's own normal, up to 20 degrees away.
    let flat = mesh.vertex_normals();
    let off = |of: &[glam::DVec3]| {
        let angle = |(n, p): (&glam::DVec3, &glam::DVec3)| n.angle_between(*p).to_degrees();
        of.iter().zip(&mesh.positions).map(angle).fold(0.0, f64::max)
    };
    assert!(off(normals) < 5.0 && off(&flat) > 10.0, "{} {}", off(normals), off(&flat));
    // What is not cut has none of its own.
    assert!(parts[1].of.len() == scene.objects[1].mesh.triangles.len() && fine.objects[1].mesh.normals.is_none());
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_borders_of_shadows_are_where_they_are() {
    for tolerance in ["transport.tolerance=1e-2", "transport.tolerance=1e-3"] {
        let fine = scene(&[tolerance, "transport.subdivide=2"]);
        let mut plain = fine.clone();
        plain.transport.subdivide = 0;
        let expected = exact(&fine);
        let ((values, parts), (coarse, faces)) = (solved(&fine), solved(&plain));
        let [cut, whole] = [values, coarse].map(|values| error(&fine, &values, &expected));
        let asked = fine.transport.tolerance;
        println!("{tolerance}: {cut:.2e} of {parts} triangles, {whole:.2e} of {faces}");
        assert!(cut < 2.0 * asked, "{tolerance}: {cut} with {parts} triangles");
        assert!(whole > 2.0 * asked, "nothing to gain: {whole}");
        assert!(parts < 8 * faces, "{parts} of {faces}: too many are cut");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_estimate_knows_what_a_border_still_misses() {
    // One level of subdivision leaves a large error, two leave a small one.
    for cuts in [1, 2] {
        let scene = scene(&["transport.tolerance=1e-2", &format!("transport.subdivide={cuts}")]);
        let options = Options { estimate: true, ..options() };
        let mut session = Session::new(&scene, None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let (places, light) = (session.prepared().places(0), session.units().light);
        let (data, parts) = (&session.state().data, &session.parts()[0]);
        let [mut errors, mut estimates, mut missed] = [const { Vec::new() }; 3];
        for (&part, exact) in parts.middle.iter().zip(exact(&scene)) {
            let place = places[part as usize];
            let row = |values: &[[f32; 3]]| values[place].map(|x| f64::from(x) * light);
            let (value, own) = (row(&data.radiosity), row(&data.estimate));
            errors.push([0, 1, 2].map(|c| (value[c] - exact[c]).abs()));
            estimates.push([0, 1, 2].map(|c| own[c].hypot(session.missed(place)[c])));
            missed.push(own);
        }
        let counts = vec![1.0; errors.len()];
        let [with, without] = [&estimates, &missed].map(|estimates| Quality::of(&counts, estimates, &errors));
        println!("{cuts}: {with:?}, without {without:?}");
        assert!(with.covered >= 0.999 && with.ratio < 20.0 && with.rank > 0.5, "{with:?}");
        assert!(cuts == 2 || without.covered < 0.99, "nothing is missed: {without:?}");
    }
}

#[test]
fn only_what_needs_it_is_cut() {
    let mut unlit = scene(&["transport.subdivide=3"]);
    unlit.lights.clear();
    let (_, parts) = subdivide(&unlit, options(), false).unwrap().unwrap();
    assert_eq!(parts[0].of.len(), parts[0].whole.len());
    let mut lit = scene(&["transport.subdivide=1"]);
    let (fine, parts) = subdivide(&lit, options(), false).unwrap().unwrap();
    let [whole, part] = [&lit, &fine].map(|scene| scene.objects[0].mesh.triangles.len());
    assert!(part > whole && part < 2 * whole, "{whole} {part}");
    // Every triangle has all of its parts, and its centre is in one of them.
    let mut count = vec![0; whole];
    parts[0].of.iter().for_each(|&face| count[face as usize] += 1);
    assert!(count.iter().all(|&n| n == 1 || n == 4));
    assert!((0..whole).all(|face| parts[0].of[parts[0].middle[face] as usize] == face as u32));
    // Without the plate there is no border.
    lit.objects.truncate(1);
    lit.lights.truncate(1);
    let (_, parts) = subdivide(&lit, options(), false).unwrap().unwrap();
    assert_eq!(parts[0].of.len(), whole);
}

#[test]
fn a_moved_light_moves_the_cuts() {
    let first = scene(&["transport.subdivide=1"]);
    let second = scene(&["transport.subdivide=1", "light.0.direction=[-0.3, 0.2, 1]"]);
    let mut session = Session::new(&first, None, options()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let before = session.parts()[0].of.clone();
    session.set_lights(&second.lights).unwrap();
    session.frame(Change::default()).unwrap();
    let fresh = Session::new(&second, None, options()).unwrap();
    assert!(session.parts()[0].of == fresh.parts()[0].of && session.parts()[0].of != before);
}
