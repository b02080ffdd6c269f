//! Malformed scene files.

use super::Case;

const GOOD: &str = "[[object]]\nshape = 'sphere'\ndetail = 0\nmaterial = { preset = 'marble' }\n";

pub fn cases() -> Vec<Case> {
    let cases = [files(), objects(), other_tables()].concat();
    let mut cases: Vec<Case> = cases
        .into_iter()
        .map(|(text, words)| Case::new(&[("a.toml", text.as_bytes())], "render a.toml -o a.png --device cpu", words))
        .collect();
    let bytes: [(&[u8], &str); 2] =
        [(b"\xff\xfe\0", "found UTF-16 text, not UTF-8"), (b"unit = '\xe9'", "invalid utf-8")];
    let line = "render a.toml -o a.png --device cpu";
    cases.extend(bytes.map(|(bytes, words)| Case::new(&[("a.toml", bytes)], line, words)));
    cases
}

/// Files that are no scenes, or too large.
fn files() -> Vec<(String, &'static str)> {
    let deep = format!("x = {}1{}", "[".repeat(9000), "]".repeat(9000));
    let tables = format!("x = {}1{}", "{a=".repeat(9000), "}".repeat(9000));
    let dotted = format!("{}x = 1", "a.".repeat(9000));
    let many = GOOD.replace("detail = 0", "detail = 8").repeat(256);
    let long = "#".repeat((1 << 22) + 1);
    vec![
        (String::new(), "a.toml: object: there is nothing to show"),
        ("\0".into(), "a.toml:1"),
        ("\u{feff}".into(), "nothing to show"),
        (deep, "lists or tables too deep in one another"),
        (tables, "lists or tables too deep in one another"),
        (dotted, "lists or tables too deep in one another"),
        (many, "object: the shapes do not fit the memory; found up to 335544320 triangles"),
        (long, "the scene file cannot be read; found 4194305 bytes; expected at most 4194304 bytes"),
    ]
}

fn objects() -> Vec<(String, &'static str)> {
    let instead = |from: &str, to: &str| GOOD.replace(from, to);
    vec![
        (instead("detail = 0", "detail = 1e9"), "a.toml:3: object.0.detail: invalid type"),
        (instead("detail = 0", "detail = 99999999999999999999"), "a.toml:3"),
        (instead("detail = 0", "detail = -1"), "a.toml:3: object.0.detail: out of range; found -1; expected 0 to 8"),
        (instead("'sphere'", "'sphere"), "a.toml:2"),
        (instead("'sphere'", "\"\\ud800\""), "a.toml:2"),
        (instead("shape = 'sphere'\ndetail = 0", "mesh = ''"), "a.toml:2: object.0.mesh: no file is named"),
        (instead("shape = 'sphere'\ndetail = 0", "mesh = '/dev/zero'"), "/dev/zero: the mesh is not a plain file"),
        (instead("shape = 'sphere'\ndetail = 0", "mesh = 'a.toml'"), "a.toml: "),
        (instead("shape = 'sphere'\ndetail = 0", "mesh = \"a\\u0000b.obj\""), "the mesh file cannot be read"),
        (instead("preset = 'marble'", "sigma_s_prime = 0, sigma_a = 0"), "a channel neither scatters nor absorbs"),
        (instead("preset = 'marble'", "sigma_s_prime = 1e308, sigma_a = 1e308, scale = 1e9"), "a finite number"),
        (instead("preset = 'marble'", "preset = 'marble', texture = '/dev/zero.png'"), "object.0.material.texture"),
        (
            instead("preset = 'marble'", "preset = 'marble', texture = 'builtin:'"),
            "no texture of this name is built in",
        ),
        (instead("preset = 'marble'", "preset = 'marble', eta = nan"), "object.0.material.eta: not a finite number"),
    ]
}

fn other_tables() -> Vec<(String, &'static str)> {
    let with = |text: &str| format!("{GOOD}{text}");
    let light = "[[light]]\ntype = 'directional'\ndirection = [0, 0, 1]\nirradiance = 1\n";
    vec![
        (with("[camera]\nsize = [0, 5]"), "a.toml:6: camera.size: not a picture size; found [0, 5]"),
        (with("[camera]\nsize = [99999999999, 1]"), "camera.size: not a picture size"),
        (with("[camera]\nsize = [16384, 16384]"), "a frame does not fit the memory; found 20 triangles, 16384 x 16384"),
        (
            with("[camera]\nsamples = 65"),
            "camera.samples: out of range; found 65; expected a whole number from 1 to 64",
        ),
        (with("[camera]\nfov = 180"), "camera.fov: out of range"),
        (with("[camera]\nfov = { keyframes = [] }"), "camera.fov: not a list of keyframes"),
        (
            with("[camera]\nfov = { keyframes = [[0, 1e999]] }"),
            "a.toml:6: camera.fov.keyframes.0.1: floating-point number overflowed",
        ),
        (with("[transport]\ntolerance = 0"), "transport.tolerance: out of range; found 0; expected 1e-6 to 0.5"),
        (with("[transport]\nsubdivide = 5"), "transport.subdivide: out of range; found 5; expected 0 to 4"),
        (with("[transport]\nhierarchy = 'butterfly'\nlevels = 99"), "transport.levels: out of range; found 99"),
        (with("[transport]\ncdrf_table = 4294967295"), "transport.cdrf_table: out of range"),
        (with("[transport]\nblur_texture = 1000000"), "transport.blur_texture: out of range"),
        (with("[[light]]\ntype = 'environment'\nradiance = 1\nocclusion = 4097"), "light.0.occlusion: out of range"),
        (with("[[light]]\ntype = 'point'\nposition = [1e10, 0, 0]\nintensity = 1"), "light.0.position: out of range"),
        (with("[[light]]\ntype = 'point'\nposition = [0, 0, 0]\nintensity = 1"), "the light stands in the medium"),
        (with(&light.repeat(20_000)), "too many samples of all lights together; found 20000"),
        (with("[[object.deform]]\ntype = 'noise'\namplitude = 1\nscale = 0"), "object.0.deform.0.scale: out of range"),
        (with("[[object.deform]]\ntype = 'morph'\nmesh = 'b'\nweight = 1"), "a built-in shape has no file"),
        (with("[object.material]\npreset = 'milk'"), "a.toml:5"),
        (GOOD.repeat(257), "too many objects; found 257 times [[object]]; expected 1 to 256"),
    ]
}
