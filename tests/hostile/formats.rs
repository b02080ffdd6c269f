//! Malformed PLY, STL and glTF files.

use super::Case;

const LINE: &str = "solve m -o a.csv --device cpu";

fn ply(head: &str, rest: &[u8]) -> Vec<u8> {
    [format!("ply\nformat {head}end_header\n").as_bytes(), rest].concat()
}

/// The name of a file, its bytes, and words of the message.
type Mesh = (&'static str, Vec<u8>, &'static str);

pub fn ply_and_stl() -> Vec<Case> {
    let cases = [ply_files(), stl_files()].concat();
    cases
        .into_iter()
        .map(|(name, bytes, words)| Case::new(&[(name, &bytes)], &LINE.replace(" m ", &format!(" {name} ")), words))
        .collect()
}

fn ply_files() -> Vec<Mesh> {
    let vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let face = |list: &str| format!("{vertex}element face 1\nproperty list {list} vertex_indices\n");
    let ascii = |head: &str, rest: &str| ply(&format!("ascii 1.0\n{head}"), rest.as_bytes());
    let little = |head: &str, rest: &[u8]| ply(&format!("binary_little_endian 1.0\n{head}"), rest);
    let big = "binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let last = (0..3).map(|k| (k as f32).to_be_bytes()).collect::<Vec<_>>().concat();
    let three = "0 0 0\n1 0 0\n0 1 0\n";
    let zeros = [0u8; 36];
    vec![
        ("m", b"ply\n".to_vec(), "m:2: the mesh file is not PLY as it should be: Unexpected end of file"),
        ("m", b"ply\nend_header\n".to_vec(), "m: the mesh file is not PLY as it should be: No format line found"),
        ("m", b"ply\nformat ascii 9999999999.0\nend_header\n".to_vec(), "the mesh file is not PLY as it should be"),
        ("m", b"ply\nformat middle 1.0\nend_header\n".to_vec(), "m:2: "),
        ("m.ply", b"junk".to_vec(), "m.ply:1: the mesh file is not PLY as it should be: Expected magic number"),
        ("m", ascii("property float x\n", ""), "m:3: "),
        ("m", ascii("element vertex 99999999999999999999\n", ""), "m:3: "),
        ("m", ascii("element vertex 18446744073709551615\nproperty double x\n", ""), "shorter than its header states"),
        ("m", little("element vertex 4000000000\n", &zeros), "shorter than its header states"),
        ("m", little("element pad 37\nelement vertex 1\n", &zeros), "m: the file is shorter than its header states"),
        ("m", little("element pad 30\nelement vertex 1\n", &zeros), "m: the vertices have no position; found no prop"),
        ("m", ascii("", ""), "m: the mesh has no faces; found 0 faces"),
        ("m", ascii(vertex, three), "m: the mesh has no faces"),
        ("m", ascii(vertex, "0 0 0\n1 0\n0 1 0.0000\n"), "m:9: "),
        ("m", ascii(vertex, "0 0 0\n1 0 nan\n0 1 0\n"), "m:9: "),
        (
            "m",
            ascii(&face("uchar int"), &format!("{three}3 0 1 3\n")),
            "m: a face names a vertex that is not there; found 3",
        ),
        ("m", ascii(&face("uchar int"), &format!("{three}3 0 1 -1\n")), "found a negative number in face 0"),
        ("m", ascii(&face("uchar int"), &format!("{three}3 0 0 1\n")), "m: every face of the mesh is degenerate"),
        ("m", ascii(&face("uchar int"), &format!("{three}2 0 1\n")), "m: the mesh has no faces; found 1 faces"),
        ("m", ascii(&face("uchar float"), &format!("{three}3 0 1 2\n")), "the mesh file is not PLY as it should be"),
        ("m", ascii(&face("int int"), &format!("{three}-3 0 1 2\n")), "the mesh file is not PLY as it should be"),
        ("m", ascii(&face("uchar int"), &format!("{three}x 0 1 2\n")), "the mesh file is not PLY as it should be"),
        (
            "m",
            ascii(&face("uint int"), &format!("{three}4000000000 0 1 2\n")),
            "the mesh file is not PLY as it should be",
        ),
        ("m", little(&face("uint int"), &[&zeros[..], &[255; 4], &[0; 12]].concat()), "not PLY as it should be"),
        ("m", little(&face("uint uint"), &[&zeros[..], &[3, 0, 0, 0], &[255; 12]].concat()), "a face names a vertex"),
        ("m", ply(big, &last), "m: the mesh has no faces"),
    ]
}

/// STL, and what is no mesh.
fn stl_files() -> Vec<Mesh> {
    let stl = |count: u32, body: usize| [&[b' '; 80][..], &count.to_le_bytes(), &vec![0; body]].concat();
    let facet =
        |corners: &str| format!("solid\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n").into_bytes();
    vec![
        ("m", stl(0, 0), "m: the mesh has no faces; found no triangle"),
        ("m", stl(1, 50), "m: every face of the mesh is degenerate"),
        ("m.stl", stl(u32::MAX, 50), "m.stl: the mesh file is neither ascii nor binary STL; found 134 bytes"),
        ("m.stl", stl(2, 50), "which state 2 triangles; expected `solid`, or a file of 84 bytes and 50 per triangle"),
        ("m.stl", Vec::new(), "m.stl: the mesh file is neither ascii nor binary STL; found 0 bytes"),
        ("m", facet("vertex 0 0 0\nvertex 1 0 0\n"), "m:7: a facet has not three corners; found 2"),
        ("m", facet("vertex 0 0 0\nvertex 1 0 0\nvertex 2 0 0\n"), "m: every face of the mesh is degenerate"),
        ("m", facet("vertex 0 0 0\nvertex 1 0 inf\nvertex 2 0 0\n"), "m:5: a coordinate is not finite or too large"),
        ("m", facet("vertex 0 0 0\nvertex 1 0 1e31\nvertex 2 0 0\n"), "m:5: a coordinate is not finite or too large"),
        ("m", facet("vertex 0 0 0\nvertex 1 0\nvertex 2 0 0\n"), "m:5: a vertex is not three numbers; found 2"),
        ("m", facet("corner 0 0 0\n"), "m:4: not a statement of ascii STL; found `corner`"),
        ("m", b"junk\x00".to_vec(), "m:1: neither a mesh nor a scene in TOML"),
        ("m", b"\xff\xfe\xfd".to_vec(), "expected a scene in TOML, or a mesh in Wavefront OBJ, PLY, STL or glTF"),
    ]
}

/// A GLB with this JSON and these bytes.
fn glb(json: &str, bytes: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", bytes)].concat();
    [&b"glTF\x02\0\0\0"[..], &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
}

const GOOD: &str = r#""bufferView":0,"componentType":5126,"count":3,"type":"VEC3""#;
const POSITIONS: &str = r#""attributes":{"POSITION":0}"#;
const NODE: &str = r#""nodes":[{"mesh":0}]"#;

/// The positions of a triangle.
fn positions() -> Vec<u8> {
    [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A GLB of a triangle with this accessor, this primitive, and this rest.
fn triangle(accessor: &str, primitive: &str, rest: &str) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{{accessor}}}],"meshes":[{{"primitives":[{{{primitive}}}]}}],{rest}}}"#
    );
    glb(&json, &positions())
}

fn tree(text: &str) -> Vec<u8> {
    triangle(GOOD, POSITIONS, text)
}

pub fn gltf() -> Vec<Case> {
    let cases = [heads(), trees(), primitives(), buffers(), skins()].concat();
    let line = LINE.replace(" m ", " m.glb ");
    let mut all: Vec<Case> = cases.iter().map(|(bytes, words)| Case::new(&[("m.glb", bytes)], &line, words)).collect();
    for (bytes, name, words) in animations() {
        all.push(Case::new(&[("m.glb", &bytes)], &format!("{line} --animation {name}"), words));
    }
    all
}

/// Files that are no glTF, of other versions, or with extensions that are not known.
fn heads() -> Vec<(Vec<u8>, &'static str)> {
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    let uses = |name: &str| format!(r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["{name}"]}}"#).into_bytes();
    vec![
        (b"glTF".to_vec(), "m.glb: the mesh file is not glTF 2.0 as it should be; found a header that is cut off"),
        (b"glTF\x01\0\0\0\x0c\0\0\0".to_vec(), "m.glb: another version of glTF; found 1; expected"),
        (b"glTF\x02\0\0\0\xff\xff\xff\xff".to_vec(), "m.glb: the mesh file is not glTF 2.0 as it should be"),
        (b"glTF\x02\0\0\0\x00\0\0\0".to_vec(), "found a header that is cut off"),
        (
            b"glTF\x02\0\0\0\x0c\0\0\0\xff\xff\xff\xffJSON".to_vec(),
            "m.glb: the mesh file is not glTF 2.0 as it should be",
        ),
        (b"{".to_vec(), "m.glb:1: the mesh file is not glTF 2.0 as it should be; found EOF"),
        (b"junk".to_vec(), "m.glb:1: the mesh file is not glTF 2.0 as it should be"),
        (
            format!(r#"{{"asset":{{"version":"2.0"}},"extras":{deep}}}"#).into_bytes(),
            "m.glb:1: the mesh file is not glTF",
        ),
        (
            br#"{"asset":{"version":"1.1"}}"#.to_vec(),
            "m.glb: another version of glTF; found 1.1; expected asset.version",
        ),
        (
            br#"{"asset":{"version":"2.0"},"nodes":7}"#.to_vec(),
            "m.glb:1: the mesh file is not glTF 2.0 as it should be",
        ),
        (br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":-1}]}"#.to_vec(), "not glTF 2.0 as it should be"),
        (uses("KHR_draco_mesh_compression"), "m.glb: compressed meshes are not supported; found KHR_draco"),
        (uses("EXT_meshopt_compression"), "m.glb: compressed meshes are not supported; found EXT_meshopt"),
        (
            uses("KHR_texture_procedurals"),
            "m.glb: the file requires an extension that is not known; found KHR_texture_pro",
        ),
        (uses("KHR_meshopt_compression"), "m.glb: compressed meshes are not supported; found KHR_meshopt"),
    ]
}

fn trees() -> Vec<(Vec<u8>, &'static str)> {
    let many: String = (0..60_000).map(|k| format!(r#"{{"children":[{}]}},"#, k + 1)).collect();
    vec![
        (tree(r#""nodes":[]"#), "m.glb: the mesh has no faces; found no triangles in the scene of the file"),
        (tree(r#""nodes":[{"mesh":4000000000}]"#), "m.glb: there is no mesh 4000000000"),
        (tree(r#""nodes":[{"mesh":0}],"scene":3"#), "m.glb: there is no scene 3"),
        (tree(r#""nodes":[{"mesh":0}],"scenes":[{"nodes":[5]}]"#), "m.glb: there is no node 5"),
        (tree(&format!(r#""nodes":[{many}{{"children":[0]}}]"#)), "m.glb: nodes are their own ancestors; found 60001"),
        (tree(r#""nodes":[{"children":[1]},{"mesh":0},{"children":[1]}]"#), "m.glb: nodes.1: a node has two parents"),
        (tree(r#""nodes":[{"mesh":0,"scale":[0,0,0]}]"#), "m.glb: every face of the mesh is degenerate"),
        (tree(r#""nodes":[{"mesh":0,"translation":[1e39,0,0]}]"#), "m.glb: a coordinate is not finite or too large"),
        (tree(r#""nodes":[{"mesh":0,"scale":[1e35,1,1]}]"#), "m.glb: a coordinate is not finite or too large; found ["),
    ]
}

fn primitives() -> Vec<(Vec<u8>, &'static str)> {
    let accessor = |text: &str| triangle(text, POSITIONS, NODE);
    let primitive = |text: &str| triangle(GOOD, &format!("{POSITIONS},{text}"), NODE);
    vec![
        (primitive(r#""indices":5"#), "m.glb: there is no accessor 5"),
        (primitive(r#""indices":0"#), "an element has not as many numbers as it should; found 3; expected 1"),
        (primitive(r#""mode":0"#), "m.glb: the mesh has no faces"),
        (primitive(r#""mode":77"#), "m.glb: the mesh has no faces"),
        (primitive(r#""targets":[{"POSITION":9}]"#), "m.glb: there is no accessor 9"),
        (primitive(r#""material":0"#), "m.glb: there is no material 0"),
        (accessor(r#""componentType":5126,"count":1000000000000,"type":"VEC3""#), "of memory asked for beside"),
        (accessor(r#""componentType":5126,"count":18446744073709551615,"type":"VEC3""#), "of memory asked for beside"),
        (accessor(r#""componentType":5126,"count":3,"type":"VEC3""#), "m.glb: every face of the mesh is degenerate"),
        (accessor(&format!(r#"{GOOD},"byteOffset":1"#)), "accessors.0: it reaches beyond its buffer view"),
        (
            accessor(&format!(r#"{GOOD},"byteOffset":18446744073709551615"#)),
            "accessors.0: it reaches beyond its buffer view",
        ),
        (accessor(&GOOD.replace("5126", "5130")), "accessors.0: its type is not one of glTF's"),
        (accessor(&GOOD.replace("VEC3", "VEC9")), "accessors.0: its type is not one of glTF's"),
        (
            accessor(&format!(
                r#"{GOOD},"sparse":{{"count":1,"indices":{{"bufferView":0,"byteOffset":12,"componentType":5125}},"values":{{"bufferView":0}}}}"#
            )),
            "accessors.0: a sparse index is beyond its elements; found 1065353216",
        ),
    ]
}

fn buffers() -> Vec<(Vec<u8>, &'static str)> {
    let uri = |uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"{uri}"}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{{GOOD}}}],"meshes":[{{"primitives":[{{{POSITIONS}}}]}}],{NODE}}}"#
        )
        .into_bytes()
    };
    vec![
        (uri("gone.bin"), "m.glb: buffers.0: its file cannot be read; found gone.bin: No such file"),
        (uri("/dev/zero"), "m.glb: buffers.0: its file cannot be read; found /dev/zero: not a plain file"),
        (uri("http://localhost/a"), "m.glb: buffers.0: only files beside the mesh are read"),
        (uri("data:;base64,!"), "m.glb: buffers.0: its data cannot be read"),
        (uri("data:;base64,AAAA"), "bufferViews.0: it reaches beyond its buffer"),
    ]
}

fn skins() -> Vec<(Vec<u8>, &'static str)> {
    let skin = |rest: &str| {
        let attributes = r#""attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":1}"#;
        let four = r#","componentType":5126,"count":3,"type":"VEC4","bufferView":1"#;
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":84}}],"bufferViews":[{{"buffer":0,"byteLength":36}},
            {{"buffer":0,"byteOffset":36,"byteLength":48}}],"accessors":[{{{GOOD}}},{{"byteOffset":0{four}}}],
            "meshes":[{{"primitives":[{{{attributes}}}]}}],"nodes":[{{"mesh":0,"skin":0}}]{rest}}}"#
        );
        let joints: Vec<u8> = [9.0f32; 12].iter().flat_map(|x| x.to_le_bytes()).collect();
        glb(&json, &[positions(), joints].concat())
    };
    vec![
        (skin(""), "m.glb: there is no skin 0"),
        (skin(r#","skins":[{"joints":[0]}]"#), "a vertex names a joint that its skin does not have; found 9"),
        (skin(r#","skins":[{"joints":[8]}]"#), "m.glb: there is no node 8"),
        (
            skin(r#","skins":[{"joints":[0],"inverseBindMatrices":0}]"#),
            "an element has not as many numbers as it should",
        ),
    ]
}

/// A file, the name of the animation that is asked for, and words of the message.
fn animations() -> [(Vec<u8>, &'static str, &'static str); 4] {
    let animation = |sampler: &str, target: &str| {
        tree(&format!(
            r#"{NODE},"animations":[{{"name":"A","samplers":[{{{sampler}}}],"channels":[{{"sampler":0,"target":{{{target}}}}}]}}]"#
        ))
    };
    let (plain, move_it) = (r#""input":0,"output":0"#, r#""node":0,"path":"translation""#);
    [
        (
            tree(NODE),
            "A",
            "animation: no mesh of the scene has this animation; found A; expected a glTF file with anim",
        ),
        (animation(plain, move_it), "B", "an element has not as many numbers as it should; found 3; expected 1"),
        (animation(plain, move_it), "A", "an element has not as many numbers as it should; found 3; expected 1"),
        (animation(r#""input":7,"output":0"#, move_it), "A", "there is no accessor 7"),
    ]
}
