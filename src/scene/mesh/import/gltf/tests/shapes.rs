//! Primitives, nodes and skins.

use super::*;
use glam::DVec3;

#[test]
fn every_kind_of_primitive_gives_triangles() {
    let mut file = Builder::default();
    let places = file.floats(&CORNERS);
    let one = file.floats(&CORNERS[..3]);
    let strip = file.shorts(&[[0], [1], [2], [2], [3]], "");
    // 0, 1 and 2 of 65,535 as shares of 1.
    let quantized = file.shorts(&[[0, 0, 0], [65535, 0, 0], [0, 65535, 0]], r#","normalized":true"#);
    let (at, to) = (file.view(&[2]), file.view(&[5.0f32, 6.0, 7.0].map(f32::to_le_bytes).concat()));
    file.accessors.push(format!(
        r#"{{"componentType":5126,"count":3,"type":"VEC3","bufferView":1,"sparse":{{"count":1,
            "indices":{{"bufferView":{at},"byteOffset":0,"componentType":5121}},
            "values":{{"bufferView":{to},"byteOffset":0}}}}}}"#
    ));
    let sparse = file.accessors.len() - 1;
    let of = |primitive: String| {
        let bytes = file.glb(&format!(r#""meshes":[{{"primitives":[{{{primitive}}}]}}],"nodes":[{{"mesh":0}}]"#));
        soup(&bytes, None, None).expect("triangles")
    };
    let position = |accessor: usize| format!(r#""attributes":{{"POSITION":{accessor}}}"#);
    assert_eq!(of(position(one)).triangles, [[0, 1, 2]]);
    let mesh = of(format!(r#"{},"mode":5,"indices":{strip}"#, position(places)));
    // The triangles that join strips have no area.
    assert_eq!((mesh.triangles, mesh.positions.len()), (vec![[0, 1, 2], [2, 3, 3]][..1].to_vec(), 3));
    assert_eq!(of(format!(r#"{},"mode":5"#, position(places))).triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(of(format!(r#"{},"mode":6"#, position(places))).triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(of(position(quantized)).positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(of(position(sparse)).positions[2], DVec3::new(5.0, 6.0, 7.0));
}

#[test]
fn nodes_place_copies_of_a_mesh_and_mirrors_turn_it_around() {
    let mut file = Builder::default();
    let one = file.floats(&CORNERS[..3]);
    let rest = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{one}}}}},{{"attributes":{{"POSITION":{one}}},"mode":0}}]}}],
        "nodes":[{{"children":[1,2],"translation":[0,0,5]}},{{"mesh":0,"scale":[-2,2,2]}},
                 {{"mesh":0,"rotation":[0,0,0.70710678,0.70710678]}},{{"mesh":0}}],
        "scene":0,"scenes":[{{"nodes":[0]}}]"#
    );
    let mesh = soup(&file.glb(&rest), None, None).expect("two triangles");
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (2, 6));
    let corners = mesh.triangles[0].map(|corner| mesh.positions[corner as usize]);
    assert_eq!(corners, [DVec3::new(-2.0, 0.0, 5.0), DVec3::new(0.0, 0.0, 5.0), DVec3::new(0.0, 2.0, 5.0)]);
    let turned = mesh.positions[mesh.triangles[1][1] as usize];
    assert!((turned - DVec3::new(0.0, 1.0, 5.0)).length() < 1e-7, "{turned}");
}

#[test]
fn normals_are_turned_with_their_nodes() {
    let mut file = Builder::default();
    let one = file.floats(&CORNERS[..3]);
    let normals = file.floats(&[[0.0f32, 0.0, 1.0], [0.0, 0.6, 0.8], [0.6, 0.0, 0.8]]);
    let target = file.floats(&[[0.0f32, 0.0, 4.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
    let with = format!(r#""attributes":{{"POSITION":{one},"NORMAL":{normals}}}"#);
    let rest = format!(
        r#""meshes":[{{"primitives":[{{{with}}}]}},{{"primitives":[{{"attributes":{{"POSITION":{one}}}}}]}},
                     {{"weights":[0.5],"primitives":[{{{with},"targets":[{{"POSITION":{target}}}]}}]}}],
        "nodes":[{{"mesh":0}},{{"mesh":0,"scale":[1,-2,1]}},{{"mesh":0,"rotation":[0.70710678,0,0,0.70710678]}},
                 {{"mesh":1}},{{"mesh":2}}]"#
    );
    let all = soup(&file.glb(&rest), None, None).expect("triangles").normals.expect("normals");
    // A mirror turns its triangles around, and the normals over.
    let slanted = -DVec3::new(0.0, -0.3, 0.8).normalize();
    let wanted = [
        [DVec3::Z, DVec3::new(0.0, 0.6, 0.8), DVec3::new(0.6, 0.0, 0.8)],
        [slanted, -DVec3::Z, -DVec3::new(0.6, 0.0, 0.8)],
        [-DVec3::Y, DVec3::new(0.0, -0.8, 0.6), DVec3::new(0.6, -0.8, 0.0)],
        [DVec3::ZERO; 3],
        [DVec3::ZERO; 3],
    ];
    for (found, wanted) in all.iter().flatten().zip(wanted.iter().flatten()) {
        assert!(found.distance(*wanted) < 1e-6, "{found}, not {wanted}: {all:?}");
    }
    let bare = file
        .glb(&format!(r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{one}}}}}]}}],"nodes":[{{"mesh":0}}]"#));
    assert_eq!(soup(&bare, None, None).expect("a triangle").normals, None);
}

#[test]
fn joints_and_targets_place_the_vertices() {
    let mut file = Builder::default();
    let one = file.floats(&CORNERS[..3]);
    let target = file.floats(&[[0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
    let joints = file.shorts(&[[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]], "");
    let weights = file.floats(&[[0.5f32, 0.5, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]);
    let mut lift = [0.0f32; 16];
    [0, 5, 10, 15].into_iter().for_each(|k| lift[k] = 1.0);
    let plain = lift;
    lift[12] = -1.0;
    let inverse = file.floats(&[plain, lift]);
    let rest = format!(
        r#""meshes":[{{"weights":[0.25],"primitives":[{{"attributes":{{"POSITION":{one},"JOINTS_0":{joints},"WEIGHTS_0":{weights}}},
            "targets":[{{"POSITION":{target}}}]}}]}}],
        "nodes":[{{"mesh":0,"skin":0,"translation":[100,0,0]}},{{"children":[2]}},{{"translation":[1,3,0]}}],
        "skins":[{{"joints":[1,2],"inverseBindMatrices":{inverse}}}]"#
    );
    let mesh = soup(&file.glb(&rest), None, None).expect("a triangle");
    // The first vertex is halfway between the joints, the second follows the joint that was lifted by 3.
    let expected = [DVec3::new(0.0, 1.5, 1.0), DVec3::new(1.0, 3.0, 0.0), DVec3::Y];
    assert_eq!(mesh.positions, expected);
}
