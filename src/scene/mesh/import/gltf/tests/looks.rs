//! Textures, colours, materials, lights and cameras.

use super::*;

/// A triangle with these further attributes and this material.
fn triangle(file: &mut Builder, attributes: &str, material: &str) -> String {
    let one = file.floats(&CORNERS[..3]);
    format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{one}{attributes}}},"material":0}}]}}],
        "nodes":[{{"mesh":0}}],"materials":[{{{material}}}]"#
    )
}

/// A PNG of one row: linear 0 and 1 in red.
fn png() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([255 * x as u8, 0, 0]));
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("written");
    bytes.into_inner()
}

fn texels(bytes: &[u8]) -> Texels {
    texture(&Files::default(), Path::new("a.glb"), bytes, None).expect("a texture")
}

#[test]
fn an_image_is_placed_by_the_texture_transform() {
    let mut file = Builder::default();
    let uv = file.floats(&[[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let view = file.view(&png());
    let material = r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,1,1,1],"baseColorTexture":{"index":0,
        "extensions":{"KHR_texture_transform":{"offset":[0,1],"rotation":1.5707963267948966,"scale":[0.5,0.5]}}}}"#;
    let rest = triangle(&mut file, &format!(r#","TEXCOORD_0":{uv}"#), material)
        + &format!(r#","textures":[{{"source":0}}],"images":[{{"bufferView":{view},"mimeType":"image/png"}}]"#);
    let bytes = file.glb(&rest);
    // The extension's example: the lower left quadrant, turned clockwise; our v runs upwards.
    let uvs = soup(&bytes, None, Some(true)).expect("a triangle").uvs.expect("coordinates")[0];
    for (place, expected) in uvs.iter().flatten().zip([0.0, 0.0, 0.0, 0.5, 0.5, 0.0]) {
        assert!((place - expected).abs() < 1e-9, "{uvs:?}");
    }
    assert_eq!(soup(&bytes, None, Some(false)).expect("a triangle").uvs.expect("them")[0][2], [0.0, 0.0]);
    assert_eq!(texels(&bytes), ([2, 1], vec![[0.0; 3], [0.5, 0.0, 0.0]]));
}

#[test]
fn without_an_image_colours_of_vertices_or_of_the_material_tint() {
    let mut file = Builder::default();
    let colors = file.floats(&[[1.0f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let factor = r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1]}"#;
    let rest = triangle(&mut file, &format!(r#","COLOR_0":{colors}"#), factor);
    let bytes = file.glb(&rest);
    let corners = [[0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 1.0], [0.0, 0.25, 1.0]];
    assert_eq!(texels(&bytes), ([2, 2], corners.to_vec()));
    assert_eq!(
        soup(&bytes, None, Some(true)).expect("one").uvs.expect("them")[0],
        [[0.25, 0.75], [0.75, 0.75], [0.25, 0.25]]
    );
    let mut file = Builder::default();
    let rest = triangle(&mut file, "", factor);
    assert_eq!(texels(&file.glb(&rest)), ([1, 1], vec![[0.5, 0.25, 1.0]]));
}

#[test]
fn materials_lights_and_cameras_become_a_scene() {
    let mut file = Builder::default();
    let one = file.floats(&CORNERS[..3]);
    let rest = format!(
        r#""extensionsUsed":["KHR_lights_punctual","KHR_xmp","KHR_xmp"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"directional","intensity":683}},
            {{"type":"spot","color":[1,0.5,0],"intensity":1366,"spot":{{"outerConeAngle":0.5}}}}]}}}},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{one}}},"material":0}},{{"attributes":{{"POSITION":{one}}}}}]}}],
        "nodes":[{{"mesh":0,"scale":[2,2,2]}},{{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},
            {{"translation":[1,1,3],"extensions":{{"KHR_lights_punctual":{{"light":1}}}}}},{{"camera":0,"translation":[1,1,8]}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
        "materials":[{{"name":"wax","pbrMetallicRoughness":{{"roughnessFactor":0.5}},"extensions":{{
            "KHR_materials_ior":{{"ior":1.4}},"KHR_materials_volume":{{"attenuationDistance":0.001,"attenuationColor":[0.36787944117144233,0.36787944117144233,0.36787944117144233]}},
            "KHR_materials_volume_scatter":{{"multiscatterColor":[1,1,0],"scatterAnisotropy":0.5}}}}}}]"#
    );
    let around: Table = toml::from_str(
        "[camera]\nfov = 3\nsamples = 4\n[[light]]\ntype = 'point'\n[[object]]\nmesh = 'a.glb'\nsize = 20\nmaterial.preset = 'marble'\n",
    )
    .expect("TOML");
    let (made, notes) = scene(&Files::default(), Path::new("a.glb"), &file.glb(&rest), around).expect("a scene");
    let object = |k: usize| &made["object"][k];
    // In mm: the mesh is 2 m across, with a mean free path of 1 mm.
    assert_eq!((object(0)["part"].as_integer(), object(0)["size"].as_float()), (Some(0), Some(2000.0)));
    let wax = &object(0)["material"];
    let near = |value: &toml::Value, expected: f64| {
        value.as_float().is_some_and(|x| (x - expected).abs() < 1e-6 * expected.max(1e-3))
    };
    assert!(
        near(&wax["sigma_s_prime"][0], 0.5) && near(&wax["sigma_a"][0], 0.0) && near(&wax["sigma_a"][2], 1.0),
        "{wax}"
    );
    assert!(
        near(&wax["eta"], 1.4) && near(&wax["roughness"], 0.25) && near(&wax["g"], 0.5) && wax.get("preset").is_none()
    );
    assert_eq!(object(1)["material"]["preset"].as_str(), Some("marble"));
    let lights = &made["light"];
    assert!(near(&lights[0]["irradiance"][0], 1.0) && near(&lights[0]["direction"][2], 1.0));
    assert!(near(&lights[1]["intensity"][1], 1e6) && near(&lights[1]["position"][2], 3000.0), "{lights}");
    let camera = &made["camera"];
    assert!(near(&camera["position"][2], 8000.0) && near(&camera["target"][2], 0.0), "{camera}");
    assert!(near(&camera["fov"], 0.5f64.to_degrees()) && camera["samples"].as_integer() == Some(4));
    assert!(near(&camera["exposure"], 683.0));
    assert!(notes.iter().any(|note| note.starts_with("lights: 2 of the file, in candela and lux")), "{notes:?}");
    let mesh = soup(&file.glb(&rest), Some(0), None).expect("a triangle");
    assert_eq!((mesh.triangles.len(), mesh.notes), (1, vec!["ignored: glTF extensions KHR_xmp".to_owned()]));
}
