//! What the format allows, and what a picture leaves out.

use super::*;
use crate::scene::skin::Pose;

/// A file of one triangle, and of this text beside it; `primitive` are further keys of its primitive.
fn triangle(primitive: &str, rest: &str) -> Vec<u8> {
    triangle_with("", primitive, rest)
}

/// The same with `more` attributes.
fn triangle_with(more: &str, primitive: &str, rest: &str) -> Vec<u8> {
    let mut file = Builder::default();
    let one = file.floats(&CORNERS[..3]);
    // An accessor that says nothing of where it is, times, and places at these times.
    file.accessors.push(r#"{"componentType":5126,"count":3,"type":"VEC3"}"#.into());
    file.floats(&[[0.0f32], [1.0]]);
    file.floats(&[[0.0f32, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let mesh = format!(r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{one}{more}}}{primitive}}}]}}]"#);
    file.glb(&format!("{mesh},{rest}"))
}

const NODE: &str = r#""nodes":[{"mesh":0}]"#;

fn triangles(bytes: &[u8]) -> Result<usize, String> {
    soup(bytes, None, None).map(|soup| soup.triangles.len())
}

#[test]
fn extras_are_any_value_and_scenes_may_be_empty() {
    for extras in ["\"a note\"", "[1,\"b\"]", "7", "null", "true", "{\"a\":[1]}"] {
        let rest = format!(
            r#"{NODE},"extras":{extras},"scene":0,"scenes":[{{"nodes":[0],"extras":{extras}}},{{"name":"empty"}}],
            "materials":[{{"extras":{extras},"pbrMetallicRoughness":{{"extras":{extras}}}}}]"#
        );
        assert_eq!(triangles(&triangle(&format!(r#","extras":{extras}"#), &rest)), Ok(1), "{extras}");
    }
    // Without a choice, what is there is shown.
    assert_eq!(triangles(&triangle("", &format!(r#"{NODE},"scenes":[{{}},{{"nodes":[0]}}]"#))), Ok(1));
    let words = triangles(&triangle("", &format!(r#"{NODE},"scene":0,"scenes":[{{}}]"#))).expect_err("an empty scene");
    assert!(words.starts_with("the mesh has no faces"), "{words}");
}

#[test]
fn channels_that_move_no_node_are_passed_over() {
    let pointer = r#"{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/materials/0/alphaCutoff"}}}"#;
    for target in [r#"{"path":"translation"}"#, pointer] {
        let rest = format!(
            r#"{NODE},"animations":[{{"samplers":[{{"input":2,"output":3}}],"channels":[{{"sampler":0,"target":{target}}},
            {{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}]"#
        );
        let bytes = triangle("", &rest);
        assert_eq!(triangles(&bytes), Ok(1));
        let moved = animated(&Files::default(), Path::new("a.glb"), &bytes, None, (0, 0.5)).expect("a pose");
        let place = |pose: &Pose| pose.matrices[0].w_axis.x;
        assert_eq!(moved.2.each_ref().map(place), [0.0, 1.0]);
    }
}

#[test]
fn compressed_meshes_are_refused_only_where_nothing_else_is_there() {
    let draco = r#","extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}"#;
    let used = |list: &str, name: &str| format!(r#"{NODE},"{list}":["{name}"]"#);
    let optional = used("extensionsUsed", "KHR_draco_mesh_compression");
    assert_eq!(triangles(&triangle("", &optional)), Ok(1));
    assert_eq!(triangles(&triangle(draco, &optional)), Ok(1));
    let refused = "compressed meshes are not supported; found ";
    let only = format!("{draco},\"indices\":1");
    for (bytes, expected) in [
        (triangle(&only, &optional), format!("{refused}KHR_draco_mesh_compression")),
        (
            triangle("", &used("extensionsRequired", "EXT_meshopt_compression")),
            format!("{refused}EXT_meshopt_compression"),
        ),
        (
            triangle("", &used("extensionsRequired", "KHR_materials_unlit")),
            "the file requires an extension that is not known; found KHR_materials_unlit; expected no other".into(),
        ),
    ] {
        let words = triangles(&bytes).expect_err(&expected);
        assert!(words.starts_with(&expected), "{words}");
    }
    // A buffer in name only, for those who do not unpack.
    let view = r#"{"buffer":1,"byteLength":36,"extensions":{"EXT_meshopt_compression":{"buffer":0}}}"#;
    let file = |uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"data:;base64,AAAA"}},{{"byteLength":36{uri}}}],
            "bufferViews":[{view}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "extensionsUsed":["EXT_meshopt_compression"],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],{NODE}}}"#
        )
    };
    let words = triangles(file("").as_bytes()).expect_err("no plain data");
    assert!(words.starts_with(&format!("{refused}EXT_meshopt_compression")), "{words}");
    let plain = r#","uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA""#;
    assert_eq!(triangles(file(plain).as_bytes()), Ok(1));
}

#[test]
fn older_versions_are_called_so() {
    let old = r#"{"asset":{"version":"1.0"},"meshes":{"m":{}},"nodes":{},"scenes":{}}"#;
    for bytes in
        [old.as_bytes(), old.replace("\"version\":\"1.0\"", "").as_bytes(), b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0"]
    {
        let words = triangles(bytes).expect_err("an old file");
        assert!(words.starts_with("another version of glTF; found 1"), "{words}");
    }
    let words = triangles(br#"{"asset":{"version":"2.0"},"nodes":7,"extras":3}"#).expect_err("no list");
    assert!(words.starts_with("the mesh file is not glTF 2.0 as it should be; found invalid type"), "{words}");
}

/// The first object's material, and what is said, of a triangle with this material.
fn look(material: &str, attributes: &str, rest: &str) -> (Table, Vec<String>) {
    let around = toml::from_str("[[object]]\nmesh = 'a.glb'\nmaterial.preset = 'marble'\n").expect("TOML");
    let rest = format!(r#"{NODE},"materials":[{{"name":"m",{material}}}]{rest}"#);
    let bytes = triangle_with(attributes, r#","material":0"#, &rest);
    let (made, notes) = scene(&Files::default(), Path::new("a.glb"), &bytes, around).expect("a scene");
    (made["object"][0]["material"].as_table().expect("a material").clone(), notes)
}

#[test]
fn a_texture_wraps_each_way_as_its_sampler_says() {
    let base = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0}}"#;
    for (modes, expected) in [
        (r#""wrapS":33071,"wrapT":10497"#, "[\"clamp\", \"repeat\"]"),
        (r#""wrapT":33648"#, "[\"repeat\", \"mirror\"]"),
        (r#""wrapS":33071,"wrapT":33071"#, "\"clamp\""),
    ] {
        let rest = format!(
            r#","textures":[{{"source":0,"sampler":0}}],"images":[{{"uri":"a.png"}}],"samplers":[{{{modes}}}]"#
        );
        assert_eq!(look(base, "", &rest).0["texture_wrap"].to_string(), expected, "{modes}");
    }
}

#[test]
fn what_a_picture_leaves_out_is_said() {
    let base = r#""pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1],"baseColorTexture":{"index":0}}"#;
    let image = |texture: &str, image: &str| format!(r#","textures":[{{{texture}}}],"images":[{{{image}}}]"#);
    let png = image(r#""source":0"#, r#""uri":"a.png""#);
    let webp = r#""extensions":{"EXT_texture_webp":{"source":0}}"#;
    let neither = "its texture is left out: its image is neither PNG nor JPEG";
    let colors = r#","COLOR_0":0"#;
    for (material, attributes, rest, expected) in [
        (base, "", png.clone(), None),
        (base, colors, png.clone(), Some("the colours of its vertices, COLOR_0, are left out beside its texture")),
        (base, "", image(webp, r#""mimeType":"image/webp","bufferView":0"#), Some(neither)),
        (base, "", image(r#""source":0"#, r#""uri":"a.WEBP""#), Some(neither)),
        (base, "", image(r#""source":0"#, r#""uri":"data:image/webp;base64,AAAA""#), Some(neither)),
        (base, "", image(&format!(r#""source":0,{webp}"#), r#""uri":"a.jpg""#), None),
        (
            r#""alphaMode":"MASK""#,
            "",
            String::new(),
            Some("its alpha mask is left out: what it would cut away is shown"),
        ),
        (r#""alphaMode":"BLEND""#, "", String::new(), Some("its opacity is left out: it is shown in full")),
        (
            r#""extensions":{"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":1}}"#,
            "",
            String::new(),
            Some("diffuse transmission without a volume is left out; it gets the material that the mesh has otherwise"),
        ),
    ] {
        let (made, notes) = look(material, attributes, &rest);
        let expected: Vec<String> = expected.map(|words| format!("material m: {words}")).into_iter().collect();
        assert_eq!(notes, expected, "{material}{rest}");
        assert_eq!(made.contains_key("texture"), material == base);
    }
    let bytes = triangle(
        r#","material":0"#,
        &format!(r#"{NODE},"materials":[{{{base}}}]{}"#, image(webp, r#""mimeType":"image/webp","bufferView":0"#)),
    );
    let tint = texture(&Files::default(), Path::new("a.glb"), &bytes, None).expect("one colour");
    assert_eq!(tint, ([1, 1], vec![[1.0, 0.0, 0.0]]));
}
