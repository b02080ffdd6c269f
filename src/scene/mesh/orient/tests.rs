//! Parts that are nested, inside out, mixed, open, crowded and one-sided.

use super::super::Shape;
use super::*;
use proptest::prelude::*;

fn ball(radius: f64, middle: DVec3) -> Mesh {
    let mut mesh = Shape::Sphere.build(1);
    mesh.positions.iter_mut().for_each(|p| *p = *p * radius + middle);
    mesh
}

fn together(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let base = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|corner| corner + base)));
    }
    all
}

fn turned(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    mesh
}

fn oriented(mut mesh: Mesh) -> (Mesh, Vec<String>) {
    let mut report = Vec::new();
    orient(&mut mesh, &mut report).expect("sides");
    (mesh, report)
}

/// The sign of the volume of each run of `count` faces.
fn signs(mesh: &Mesh, count: usize) -> Vec<bool> {
    let faces: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    faces.chunks(count).map(|part| volume(mesh, part) > 0.0).collect()
}

#[test]
fn a_good_ball_is_left_alone() {
    let good = ball(1.0, DVec3::ONE);
    let (mesh, report) = oriented(good.clone());
    assert_eq!((mesh.triangles, report.len()), (good.triangles, 0));
}

#[test]
fn a_ball_inside_out_is_reversed() {
    let (mesh, report) = oriented(turned(ball(1.0, DVec3::ONE)));
    assert!(mesh.volume() > 0.0);
    let expected = "reversed: 80 faces in 1 of 1 connected parts pointed the wrong way";
    assert_eq!(report, [expected]);
}

#[test]
fn places_in_a_texture_turn_with_their_corners() {
    let mut mesh = Shape::Sphere.build_textured(1);
    let places = mesh.uvs.clone();
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    mesh.uvs.iter_mut().flatten().for_each(|corners| corners.swap(1, 2));
    let (mesh, _) = oriented(mesh);
    assert_eq!((mesh.triangles, mesh.uvs), (Shape::Sphere.build(1).triangles, places));
}

#[test]
fn walls_of_cavities_face_them() {
    // A hollow ball with a ball in its cavity, and a separate ball, in every mixture of orientations.
    let balls = [
        ball(3.0, DVec3::ZERO),
        ball(2.0, DVec3::new(0.3, 0.0, 0.1)),
        ball(1.0, DVec3::new(0.2, 0.1, 0.0)),
        ball(1.0, DVec3::new(9.0, 0.0, 0.0)),
    ];
    for mask in 0..16 {
        let mixed: Vec<Mesh> = balls
            .iter()
            .cloned()
            .enumerate()
            .map(|(index, ball)| if mask >> index & 1 == 1 { turned(ball) } else { ball })
            .collect();
        let (mesh, report) = oriented(together(&mixed));
        assert_eq!(signs(&mesh, 80), [true, false, true, true]);
        assert!(report.contains(&"parts: 4 connected parts, 4 of them closed".to_owned()));
    }
}

#[test]
fn balls_that_overlap_or_only_share_a_box_all_face_outwards() {
    let balls = [ball(3.0, DVec3::ZERO), ball(0.3, DVec3::new(1.75, 1.75, 1.75)), ball(0.5, DVec3::new(2.3, 1.6, 0.0))];
    let (mesh, _) = oriented(together(&balls));
    assert_eq!(signs(&mesh, 80), [true, true, true]);
}

#[test]
fn an_open_part_keeps_the_side_of_most_of_its_area() {
    let mut mesh = ball(1.0, DVec3::ZERO);
    mesh.triangles.truncate(60);
    let kept = mesh.triangles.clone();
    mesh.triangles.iter_mut().take(20).for_each(|corners| corners.swap(0, 1));
    let (mesh, report) = oriented(mesh);
    let normal = |t: &[u32; 3]| {
        let smallest = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
        [t[smallest], t[(smallest + 1) % 3], t[(smallest + 2) % 3]]
    };
    assert!(mesh.triangles.iter().map(normal).eq(kept.iter().map(normal)));
    assert!(report.iter().any(|line| line.starts_with("reversed: 20 faces in 1 of ")));
    let open = format!("open: {} edges have one face only; light is transported", mesh.open_edges);
    assert!(mesh.open_edges > 0 && report.iter().any(|line| line.starts_with(&open)));
}

#[test]
fn a_moebius_strip_is_reported() {
    let mut mesh = Mesh::default();
    for step in 0..8u32 {
        let angle = f64::from(step) * std::f64::consts::TAU / 8.0;
        let (sine, cosine) = (angle / 2.0).sin_cos();
        let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
        for side in [-0.3, 0.3] {
            mesh.positions.push(out * (1.0 + side * cosine) + DVec3::Z * side * sine);
        }
        let (a, b) = (2 * step, 2 * step + 1);
        let (c, d) = if step == 7 { (1, 0) } else { (a + 2, b + 2) };
        mesh.triangles.extend([[a, c, b], [b, c, d]]);
    }
    let (mesh, report) = oriented(mesh);
    assert_eq!(mesh.open_edges, 16);
    let expected = "one-sided: 1 edges have faces that cannot agree on a side";
    assert!(report.iter().any(|line| line.starts_with(expected)), "{report:?}");
}

#[test]
fn crowded_edges_join_nothing() {
    // Two tetrahedra that share an edge: four faces meet there.
    let corners =
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    let mut mesh = Mesh { positions: corners.map(DVec3::from_array).to_vec(), ..Mesh::default() };
    for [a, b, c, d] in [[0, 2, 3, 1], [0, 4, 5, 1]] {
        mesh.triangles.extend([[a, c, b], [a, b, d], [b, c, d], [c, a, d]]);
    }
    let (mesh, report) = oriented(mesh);
    assert_eq!(mesh.open_edges, 0);
    assert_eq!(
        report,
        [
            "parts: 2 connected parts, 0 of them closed",
            "crowded: 1 edges have three faces or more; the parts that meet there count as open",
        ]
    );
}

proptest! {
    #[test]
    fn faces_turned_at_random_are_all_put_right(turns in proptest::collection::vec(any::<bool>(), 80)) {
        let mut mesh = ball(1.0, DVec3::X);
        for (corners, turn) in mesh.triangles.iter_mut().zip(&turns) {
            if *turn {
                corners.swap(1, 2);
            }
        }
        let (mesh, report) = oriented(mesh);
        prop_assert_eq!(mesh.triangles, ball(1.0, DVec3::X).triangles);
        let count = turns.iter().filter(|&&turn| turn).count();
        let expected = format!("reversed: {count} faces in 1 of 1");
        prop_assert!(count == 0 || report[0].starts_with(&expected));
    }
}
