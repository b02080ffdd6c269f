//! Hierarchies of 4-to-1 splits: butterfly subdivision and shrink-wrapping, and the quality of their trees.

use crate::shell::{bad, bytes, folder, good, numbers, read};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::scene::{Hierarchy, Scene};

const MOVED: &str = "object.0.deform=[{ type = 'noise', amplitude = 1, scale = 5 }, { type = 'twist', angle = 150 }]";
const BUTTERFLY: [&str; 4] = [MOVED, "object.0.detail=1", "transport.hierarchy=butterfly", "transport.levels=2"];
const WRAPPED: [&str; 4] = [MOVED, "object.0.detail=3", "transport.hierarchy=shrink-wrap", "transport.levels=2"];

fn load(sets: &[&str], more: &[&str]) -> Scene {
    let sets: Vec<String> = [sets, more].concat().iter().map(ToString::to_string).collect();
    Scene::load_with("sphere", &sets).unwrap()
}

fn solved(scene: &Scene) -> Session {
    let mut session = Session::new(scene, None, Options::default()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

#[test]
fn both_meet_the_tolerance_on_a_deformed_thing_with_full_blocks() {
    for sets in [BUTTERFLY, WRAPPED] {
        let scene = load(&sets, &[]);
        let mut session = solved(&scene);
        let faces = scene.objects[0].mesh.triangles.len();
        let tree = &session.prepared().trees[0];
        assert_eq!((tree.check(faces), session.prepared().spoilt[0]), (Ok(()), None));
        // Each base triangle has 16 faces, which are one block.
        assert!(session.state().data.blocks.iter().all(|block| block.count == 16));
        let error = worst(&verify(&mut session, 200, 3).unwrap());
        assert!(error.l2 < scene.transport.tolerance, "{sets:?}: {error:?}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_published_scheme_takes_them_too() {
    for sets in [BUTTERFLY, WRAPPED] {
        let mut session = solved(&load(&sets, &["transport.scheme=links"]));
        let error = worst(&verify(&mut session, 100, 3).unwrap());
        assert!(error.l2 < 0.1, "{sets:?}: {error:?}");
    }
}

#[test]
fn a_hierarchy_changes_no_more_than_the_order_of_sums() {
    // The same triangles under three trees.
    let scene = load(&BUTTERFLY, &["transport.tolerance=1e-4"]);
    let radiosity = |hierarchy| {
        let mut scene = scene.clone();
        scene.transport.hierarchy = hierarchy;
        let session = solved(&scene);
        let places = session.prepared().places(0);
        places.into_iter().map(|face| session.state().data.radiosity[face][0]).collect::<Vec<f32>>()
    };
    let expected = radiosity(Hierarchy::Butterfly);
    let mean = expected.iter().sum::<f32>() / expected.len() as f32;
    for other in [Hierarchy::Median, Hierarchy::FaceClusters] {
        let found = radiosity(other);
        assert!(found != expected, "the tree has no say");
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 2e-3 * mean), "{other:?}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn such_a_tree_stays_whatever_deforms_it() {
    let at = |angle: f64| {
        let twist = format!("object.0.deform=[{{ type = 'twist', angle = {angle} }}]");
        load(&BUTTERFLY[1..], &[&twist])
    };
    let mut moving = solved(&at(10.0));
    let before = moving.prepared().trees.clone();
    moving.show(&at(500.0)).unwrap();
    moving.frame(Change::default()).unwrap();
    let fresh = solved(&at(500.0));
    assert!(moving.prepared().trees == before && fresh.prepared().trees == before);
    for slot in [BufferId::bounds, BufferId::radiosity, BufferId::radiance] {
        assert!(moving.state().data.bytes(slot) == fresh.state().data.bytes(slot), "{slot:?}");
    }
    // The median tree of the same triangles would be rebuilt here.
    let mut median = at(500.0);
    median.transport.hierarchy = Hierarchy::Median;
    assert!(solved(&median).prepared().spoilt[0].is_some());
}

#[test]
fn parts_of_parts_belong_to_the_tree() {
    // Subdivided once more at the edge of a light cone.
    let lamp = "light.0={ type = 'spot', position = [0, 0, 40], direction = [0, 0, -1], intensity = 900, outer = 4, inner = 3.8 }";
    let session = solved(&load(&BUTTERFLY[1..], &[lamp, "transport.subdivide=1", "transport.tolerance=0.01"]));
    let mesh = &session.scene().objects[0].mesh;
    assert!(mesh.splits.contains(&3) && mesh.splits.contains(&2) && mesh.splits.len() == mesh.triangles.len());
    assert_eq!(session.prepared().trees[0].check(mesh.triangles.len()), Ok(()));
    let finest = session.state().data.blocks.iter().all(|block| block.count >= 4);
    assert!(finest, "no block is a part of a triangle of the base's parts");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_the_command_line_says_of_them() {
    let here = folder(&[]);
    let solve = "solve sphere --device cpu -o a.csv --set object.0.detail=1";
    good(&here, &format!("{solve} --set transport.hierarchy=butterfly --set transport.levels=2"));
    let (header, rows) = numbers(&read(&here, "a.csv"));
    assert_eq!(rows.len(), 80 * 16);
    // `input_face` is the base triangle of each triangle.
    let column = header.split(',').position(|name| name == "input_face").unwrap();
    assert!(rows.iter().enumerate().all(|(row, cells)| cells[column] == (row / 16) as f64));
    let (_, said) = good(&here, &format!("{solve} --set transport.hierarchy=shrink-wrap --set object.0.detail=4"));
    assert!(said.contains("shrink-wrapped: 5120 triangles (320 x 4^2) for 5120, volume "), "{said}");
    // Opaque objects need no hierarchy, closed or not.
    let table = "--set object.1={shape=\"plane\",position=[0,-12,0],size=60,material={opaque=true,albedo=0.5}}";
    good(
        &here,
        &format!("render sphere --device cpu -o a.png --size 20x20 {table} --set transport.hierarchy=shrink-wrap"),
    );
    assert!(bytes(&here, "a.png").len() > 100);
    for (more, words) in [
        ("hierarchy=shrink-wrap --set object.0.shape=plane", "the mesh cannot be shrink-wrapped; found 12 open edges"),
        ("hierarchy=shrink-wrap --set object.0.shape=torus --set object.0.detail=9", "found a surface with 1 handles"),
        ("hierarchy=shrink-wrap --set object.0.material.texture=builtin:tiles", "has no places in a texture"),
        ("hierarchy=butterfly --set transport.levels=8 --set object.0.detail=4", "found 5120 x 4^8 = 335544320"),
        ("levels=2", "only a hierarchy of 4-to-1 splits has levels"),
        ("hierarchy=octree", "expected face-clusters, median, butterfly, shrink-wrap"),
    ] {
        bad(&here, &format!("{solve} --set object.0.detail=3 --set transport.{more}"), 2, &["transport.", words]);
    }
}

#[test]
fn small_and_odd_meshes_are_taken_or_refused() {
    // A tetrahedron with a spike on each face: no vertex can be removed without a fold.
    let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
    let tips = [[12, 12, -12], [12, -12, 12], [-12, 12, 12], [-12, -12, -12]];
    let vertices: String = corners.iter().chain(&tips).map(|[x, y, z]: &[i32; 3]| format!("v {x} {y} {z}\n")).collect();
    let faces =
        "f 1 2 5\nf 2 3 5\nf 3 1 5\nf 1 4 6\nf 4 2 6\nf 2 1 6\nf 1 3 7\nf 3 4 7\nf 4 1 7\nf 2 4 8\nf 4 3 8\nf 3 2 8\n";
    let both = "v 10 0 0\nv 11 0 0\nv 10 1 0\nf 1 2 3\nf 3 2 1\n";
    let here = folder(&[("spikes.obj", &format!("{vertices}{faces}")), ("both.obj", both)]);
    let solve = |mesh: &str, hierarchy: &str| {
        format!("solve {mesh} --device cpu -o a.csv --set transport.hierarchy={hierarchy} --set transport.levels=1")
    };
    good(&here, &solve("spikes.obj", "shrink-wrap"));
    // Of the two sides of one triangle one stays, and new vertices stay near its edges.
    good(&here, &solve("both.obj", "butterfly"));
    let text = read(&here, "a.csv");
    let centers = text.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse::<f64>().unwrap());
    let (low, high) = centers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    assert!(text.lines().count() == 5 && high - low < 20.0, "{low} {high}\n{text}");
}
