//! What is refused.

use super::*;

#[test]
fn faults_say_what_and_where() {
    let mut file = Builder::default();
    let one = file.floats(&CORNERS[..3]);
    let far = file.shorts(&[[0], [1], [7]], "");
    file.accessors.push(r#"{"bufferView":0,"componentType":5126,"count":99999999999,"type":"VEC3"}"#.into());
    file.accessors.push(r#"{"bufferView":7,"componentType":5126,"count":3,"type":"VEC3"}"#.into());
    file.accessors.push(r#"{"componentType":5126,"count":99999999999999,"type":"VEC3"}"#.into());
    let with = |primitive: &str, nodes: &str| {
        file.glb(&format!(r#""meshes":[{{"primitives":[{{{primitive}}}]}}],"nodes":[{nodes}]"#))
    };
    let of = |accessor: usize, more: &str| format!(r#""attributes":{{"POSITION":{accessor}}}{more}"#);
    let text = |text: &str| text.as_bytes().to_vec();
    let uses = |name: &str| text(&format!(r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["{name}"]}}"#));
    let mesh = r#"{"mesh":0}"#;
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (text(r#"{"asset":{"version":"2.0"}}"#), "the mesh has no faces; found no triangles in the scene"),
        (text(r#"{"asset":{"version":"1.0"}}"#), "another version of glTF; found 1.0; expected asset.version 2.0"),
        (text(r#"{"asset":{}}"#), "not glTF 2.0 as it should be; found missing field `version`"),
        (text("glTF"), "not glTF 2.0 as it should be; found a header that is cut off"),
        (text("glTF\x02\0\0\0\x05\0\0\0"), "found a header that is cut off"),
        (uses("KHR_draco_mesh_compression"), "compressed meshes are not supported; found KHR_draco_mesh_compression"),
        (uses("EXT_meshopt_compression"), "compressed meshes are not supported; found EXT_meshopt_compression"),
        (with(&of(one, ""), r#"{"children":[1]},{"children":[0]}"#), "nodes are their own ancestors; found 2"),
        (with(&of(one, ""), r#"{"children":[1,1]},{}"#), "nodes.1: a node has two parents"),
        (with(&of(one, ""), r#"{"children":[9]}"#), "there is no node 9"),
        (with(&of(one, ""), r#"{"mesh":3}"#), "there is no mesh 3"),
        (with(&of(9, ""), mesh), "there is no accessor 9"),
        (
            with(&of(one, r#","indices":1"#), mesh),
            "a triangle names a vertex that is not there; found 7; expected numbers",
        ),
        (with(&of(one, r#","material":4"#), mesh), "there is no material 4"),
        (with(&of(far, ""), mesh), "accessors.1: an element has not as many numbers as it should; found 1; expected 3"),
        (with(&of(2, ""), mesh), "the mesh file cannot be read; found 4.4 TiB of memory asked for"),
        (with(&of(3, ""), mesh), "there is no buffer view 7"),
        (with(&of(4, ""), mesh), "of memory asked for beside"),
        (with(r#""attributes":{"NORMAL":0}"#, mesh), "the mesh has no faces"),
        (with(&of(one, r#","mode":9"#), mesh), "the mesh has no faces"),
    ];
    for (bytes, expected) in cases {
        let words = soup(&bytes, None, None).err().unwrap_or_default();
        assert!(words.contains(expected), "{words}\n{expected}");
    }
    let words = soup(&with(&of(one, ""), mesh), Some(1), None).err().unwrap_or_default();
    assert!(words.starts_with("the mesh has no such part; found 1; expected 0 to 0"), "{words}");
    let words = soup(&with(&of(one, ""), mesh), None, Some(false)).err().unwrap_or_default();
    assert!(words.starts_with("texture: the mesh has no texture coordinates"), "{words}");
}

#[test]
fn buffers_are_beside_the_file_or_in_it() {
    let file = |uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"{uri}"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]}}"#
        )
    };
    let bytes = CORNERS[..3].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let files = Files::held([("in/a b.bin".into(), bytes)], 1 << 20);
    let of = |uri: &str| {
        let read = read(&files, Path::new("in/a.gltf"), file(uri).as_bytes(), None, (None, true));
        read.map(|soup| soup.triangles.len()).map_err(|fault| fault.to_string())
    };
    assert_eq!(of("a%20b.bin"), Ok(1));
    let embedded = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    assert_eq!(of(embedded), Ok(1));
    for (uri, expected) in [
        ("gone.bin", "buffers.0: its file cannot be read; found in/gone.bin: no such file"),
        ("https://example.org/a.bin", "buffers.0: only files beside the mesh are read; found https://"),
        ("data:text/plain,x", "buffers.0: its data cannot be read; found text/plain,x"),
        ("data:;base64,AAAA", "bufferViews.0: it reaches beyond its buffer"),
        ("data:;base64,A?", "buffers.0: its data cannot be read; found Invalid"),
    ] {
        let words = of(uri).err().unwrap_or_default();
        assert!(words.starts_with(expected), "{words}");
    }
}
