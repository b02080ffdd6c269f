//! Fuzzes a mesh and, after a line of dashes, its material library; the first byte selects how a scene uses them.
#![no_main]
mod shared;

const LIGHT: &str = "[camera]\nsize = [4, 4]\n[[light]]\ntype = 'directional'\ndirection = [1, 2, 3]\nirradiance = 1\n[[object]]\nmesh = 'm.obj'\n";

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((way, rest)) = bytes.split_first() else { return };
    let cut = rest.windows(4).position(|four| four == b"----").unwrap_or(rest.len());
    let (mesh, library) = (&rest[..cut], rest.get(cut + 4..).unwrap_or_default());
    let rest = match way % 8 {
        0 => "material = { preset = 'marble' }",
        1 => "size = 20\nmaterial = { preset = 'marble', texture = 'mtl' }",
        2 => "material = { preset = 'marble', texture = 'builtin:checker' }\nsize = 1e9",
        3 => "material = { preset = 'marble' }\n[transport]\nhierarchy = 'butterfly'\nlevels = 1",
        4 => "material = { preset = 'marble' }\n[transport]\nhierarchy = 'shrink-wrap'\nlevels = 1",
        5 => "material = { preset = 'marble' }\ndeform = [{ type = 'morph', mesh = 'n.obj', weight = 0.5 }]",
        6 => "material = { opaque = true, albedo = 0.5 }",
        _ => "material = { preset = 'marble' }\nsize = 10\n[transport]\nscheme = 'links'",
    };
    let png = include_bytes!("../seeds/png/grey.png");
    // The library's text also serves as the second mesh of a morph.
    shared::load(&format!("{LIGHT}{rest}\n"), &[("m.obj", mesh), ("m.mtl", library), ("n.obj", library), ("a.png", png)]);
});
