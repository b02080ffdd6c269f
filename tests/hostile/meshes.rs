//! Malformed meshes and material libraries.

use super::Case;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn scene(rest: &str) -> String {
    format!("[[object]]\nmesh = 'm.obj'\n{rest}")
}

pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = statements()
        .into_iter()
        .map(|(text, words)| Case::new(&[("m.obj", text.as_bytes())], "solve m.obj -o a.csv --device cpu", words))
        .collect();
    // Nested tetrahedra: 2e10 pairs of faces to compare.
    let shell = |k: usize| format!("v -{k} -{k} -{k}\nv {0} -{k} -{k}\nv -{k} {0} -{k}\nv -{k} -{k} {0}\n", 9 * k);
    let faces = "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";
    let shells: String = (1..40_001).map(|k| shell(k) + faces).collect();
    let words =
        "m.obj: too many parts of the mesh lie in one another to tell walls from cavities; found 40000 closed parts";
    cases.push(Case::new(&[("m.obj", shells.as_bytes())], "solve m.obj -o a.csv --device cpu", words));
    cases.extend(settings());
    cases
}

fn statements() -> Vec<(String, &'static str)> {
    let with = |text: &str| format!("{TRIANGLE}{text}");
    vec![
        (String::new(), "m.obj: the mesh has no faces; found no `f` statement"),
        ("f 1 2 3".into(), "m.obj:1: a face names a vertex that is not there; found 1; expected vertices before faces"),
        (with("f 1 2 4"), "m.obj:4: a face names a vertex that is not there; found 4; expected 1 to 3, or -3 to -1"),
        (with("f 0 1 2"), "m.obj:4: a face names a vertex that is not there; found 0"),
        (with("f 1 2 -4"), "m.obj:4: a face names a vertex that is not there; found -4"),
        (with("f 1 2 9223372036854775807"), "m.obj:4: a face names a vertex that is not there; found 92233720368547"),
        (with("f 1 2 -9223372036854775808"), "m.obj:4: a face names a vertex that is not there; found -9223372036"),
        (with("f 1 2 4294967298"), "m.obj:4: a face names a vertex that is not there; found 4294967298"),
        (with("f 1 2 99999999999999999999"), "m.obj:4: a corner of a face is not a vertex number"),
        (with("f 1 2 3.0"), "m.obj:4: a corner of a face is not a vertex number; found `3.0`"),
        (with("f 1 2"), "m.obj:4: a face has too few corners; found 2; expected three or more"),
        (with("f"), "m.obj:4: a face has too few corners; found 0"),
        (with("f /1 /2 /3"), "m.obj:4: a corner of a face is not a vertex number; found `/1`"),
        (with("f 1 1 1"), "m.obj: every face of the mesh is degenerate; found 1 with a repeated corner"),
        (with("v 2 0 0\nf 1 2 4"), "m.obj: every face of the mesh is degenerate; found 0 with a repeated corner, 1"),
        ("v 0 0\nf 1 1 1".into(), "m.obj:1: a vertex has too few coordinates; found 2"),
        ("v".into(), "m.obj:1: a vertex has too few coordinates; found 0"),
        ("v a b c\nf 1 1 1".into(), "m.obj:1: a coordinate is not a number; found `a`"),
        ("v 1 2 nan\nv 0 0 0\nv 1 0 0\nf 1 2 3".into(), "m.obj:1: a coordinate is not finite; found NaN"),
        ("v 1 2 inf\nv 0 0 0\nv 1 0 0\nf 1 2 3".into(), "m.obj:1: a coordinate is not finite; found inf"),
        ("v 1 2 1e31\nv 0 0 0\nv 1 0 0\nf 1 2 3".into(), "m.obj:1: a coordinate is too large; found 1e31"),
        ("v 1 2 3 0\nv 0 0 0\nv 1 0 0\nf 1 2 3".into(), "m.obj:1: a coordinate is not finite; found a weight of 0"),
        ("v 1e999 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3".into(), "m.obj:1: a coordinate is not finite"),
        ("v 1,0 2 3\nf 1 1 1".into(), "m.obj:1: a coordinate is not a number; found `1,0`"),
        ("\\\n".repeat(9000), "m.obj: the mesh has no faces"),
        (with(&format!("f {}", "1 ".repeat(50_000))), "m.obj: every face of the mesh is degenerate; found 49998"),
        ("{\"obj\": 3}".into(), "m.obj: the mesh has no faces"),
        ("# v 0 0 0\n# f 1 2 3".into(), "m.obj: the mesh has no faces"),
        ("ply\nformat ascii 1.0\nelement vertex 0\nend_header".into(), "m.obj: the vertices have no position"),
        (with("f 1 2 3\nf 1 2 5"), "m.obj:5: a face names a vertex that is not there; found 5"),
        (with("f 1 \u{202e}2 3"), "m.obj:4: a corner of a face is not a vertex number"),
    ]
}

/// Meshes that fail only with certain scene settings.
fn settings() -> [Case; 10] {
    // A disk of 5,000 triangles around one vertex.
    let rim = |k: usize| (k as f64 * std::f64::consts::TAU / 5000.0).sin_cos();
    let rim: String = (0..5000).map(|k| format!("v {} {} 0\n", rim(k).0, rim(k).1)).collect();
    let disk: String = (0..5000).map(|k| format!("f 1 {} {}\n", k + 2, (k + 1) % 5000 + 2)).collect();
    // Two tetrahedra that share an edge.
    let joined = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nv 0 0 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n\
                  f 1 2 5\nf 1 6 2\nf 1 5 6\nf 2 6 5\n";
    let marble = "material = { preset = 'marble' }\n";
    let crowd = format!("v 0 0 0\n{rim}{disk}");
    let ways: [(&str, String, &'static str); 10] = [
        (&crowd, format!("{marble}[transport]\nhierarchy = 'butterfly'"), "too many triangles at one vertex"),
        (&crowd, format!("{marble}[transport]\nhierarchy = 'shrink-wrap'"), "too many triangles at one vertex"),
        (
            TETRAHEDRON,
            "material = { preset = 'marble', texture = 'builtin:tiles' }".into(),
            "m.obj:5: object.0.material",
        ),
        (TETRAHEDRON, format!("{marble}size = 1e10"), "a.toml:4: object.0.size: out of range"),
        (TETRAHEDRON, format!("{marble}[[object.deform]]\ntype = 'morph'\nmesh = 'a.toml'\nweight = 1"), "a.toml: "),
        (joined, format!("{marble}[transport]\nhierarchy = 'butterfly'"), "the mesh cannot be subdivided"),
        (joined, format!("{marble}[transport]\nhierarchy = 'shrink-wrap'"), "the mesh cannot be subdivided"),
        (
            joined,
            format!("{marble}[transport]\nhierarchy = 'shrink-wrap'\nlevels = 8"),
            "the mesh cannot be subdivided",
        ),
        ("v 1e30 0 0\nv 1e30 1 0\nv 1e30 0 1\nf 1 2 3", marble.into(), "the camera stands on the point it looks at"),
        (TETRAHEDRON, format!("{marble}[transport]\nunwrap = true"), "m.obj:5: transport.unwrap"),
    ];
    let case = |(mesh, rest, words): (&str, String, &'static str)| {
        let text = scene(&rest);
        let files: [(&str, &[u8]); 2] = [("m.obj", mesh.as_bytes()), ("a.toml", text.as_bytes())];
        Case::new(&files, "solve a.toml -o a.csv --device cpu", words)
    };
    ways.map(case)
}

/// Malformed libraries; the mesh is valid except for its `mtllib` line.
pub fn libraries() -> Vec<Case> {
    let text = scene("material = { preset = 'marble', texture = 'mtl' }\n");
    let line = "solve a.toml -o a.csv --device cpu";
    let case = |(names, library, words): (String, String, &'static str)| {
        let mesh = format!("{names}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
        let files: [(&str, &[u8]); 4] = [
            ("m.obj", mesh.as_bytes()),
            ("a.mtl", library.as_bytes()),
            ("a.toml", text.as_bytes()),
            ("a.png", b"no picture"),
        ];
        Case::new(&files, line, words)
    };
    let named = |(library, words): (String, &'static str)| ("mtllib a.mtl".into(), library, words);
    names().into_iter().chain(contents().into_iter().map(named)).map(case).collect()
}

fn image(name: &str) -> String {
    format!("newmtl a\nmap_Kd {name}\n")
}

/// The mesh's lines that name libraries, the library, and words of the message.
fn names() -> Vec<(String, String, &'static str)> {
    vec![
        (String::new(), String::new(), "m.obj: the mesh names no material library"),
        ("mtllib".into(), String::new(), "m.obj: the mesh names no material library"),
        (
            "mtllib gone.mtl".into(),
            String::new(),
            "m.obj:1: gone.mtl: the material library cannot be read; found No such",
        ),
        (
            "mtllib /dev/zero".into(),
            String::new(),
            "m.obj:1: /dev/zero: the material library cannot be read; found not a",
        ),
        ("mtllib .".into(), String::new(), "the material library cannot be read; found not a plain file"),
        ("mtllib a.mtl\n".repeat(65), image("a.png"), "m.obj:65: too many material libraries; expected at most 64"),
        ("mtllib a.mtl\nmtllib a.mtl".into(), image("a.png"), "found 2: a, a"),
    ]
}

fn contents() -> Vec<(String, &'static str)> {
    vec![
        (String::new(), "a.mtl: one material with a texture is supported in a library; found no `map_Kd`"),
        ("newmtl a".into(), "found no `map_Kd`"),
        ("map_Kd a.png".into(), "found no `map_Kd`"),
        ("newmtl a\nmap_Kd".into(), "a.mtl: the material library cannot be read"),
        ("newmtl a\nmap_Kd -s 1 1 1 -clamp on".into(), "found `map_Kd -s 1 1 1 -clamp on` without a file"),
        ("newmtl a\nKd 1 0".into(), "found no `map_Kd`"),
        ("newmtl a\nKd a b c".into(), "found no `map_Kd`"),
        ("newmtl a\nKa nan".into(), "found no `map_Kd`"),
        ("newmtl a\nNs".into(), "found no `map_Kd`"),
        ("newmtl a\nNs x".into(), "found no `map_Kd`"),
        ("newmtl a\nNi -".into(), "found no `map_Kd`"),
        ("newmtl a\nd q".into(), "found no `map_Kd`"),
        ("newmtl a\nillum 99999999999".into(), "found no `map_Kd`"),
        ("newmtl a\nillum x".into(), "found no `map_Kd`"),
        ("newmtl".into(), "a.mtl: the material library cannot be read"),
        (image("gone.png"), "object.0.material.texture: gone.png: the texture cannot be read; found No such file"),
        (image("gone"), "object.0.material.texture: not the name of a texture; found gone"),
        (image("a.mtl"), "object.0.material.texture: not the name of a texture; found a.mtl"),
        (image("/dev/zero.png"), "the texture cannot be read"),
        (image("../../../../etc/passwd"), "not the name of a texture"),
        (image(&"x".repeat(9000)), "not the name of a texture"),
        (image(&format!("{}.png", "x".repeat(9000))), "the texture cannot be read; found File name too long"),
        (image("a.png\nnewmtl b\nmap_Kd b.png"), "found 2: a, b"),
        ("\u{0}\u{1}\u{2}".into(), "found no `map_Kd`"),
        ("newmtl a\n".repeat(9000), "found no `map_Kd`"),
        (image("a.png"), "a.png: the texture cannot be read"),
    ]
}
