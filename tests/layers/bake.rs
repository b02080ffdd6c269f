//! `milkglass bake-layers`: maps of surfaces of known depth.

use crate::shell::{bad, folder, good};

/// A square facing +z at this height, which rises by `slope` along x; with or without texture coordinates.
fn square(height: f64, slope: f64, textured: bool) -> String {
    let corner = |x: f64, y: f64| format!("v {x} {y} {}\n", height + slope * x);
    let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| corner(x, y)).concat();
    match textured {
        true => format!("{corners}vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"),
        false => format!("{corners}f 1 2 3\nf 1 3 4\n"),
    }
}

#[test]
fn a_map_holds_the_depths_of_the_surfaces_below() {
    let files = [
        ("skin.obj", square(0.0, 0.0, true)),
        ("flesh.obj", square(-1.0, -0.5, false)),
        ("bone.obj", square(-1.5, 0.0, false)),
    ];
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let here = folder(&files);
    for (name, word) in [("a.png", "bright"), ("a.exr", "dark")] {
        let (out, err) =
            good(&here, &format!("bake-layers skin.obj flesh.obj bone.obj -o {name} --size 32x8 --depth {word}"));
        assert!(out.starts_with(&format!("maps = [\"{name}\"]\ndepth = \"{word}\"\nscale = 1.9")), "{out}");
        let scale: f64 = out.lines().nth(2).unwrap().trim_start_matches("scale = ").parse().unwrap();
        assert!(!err.contains("from behind"), "{err}");
        // Triangles cover the left half; the other texels take the nearest value.
        assert!(out.contains("# 128 of 256 texels are covered by triangles, 0 rays met nothing"), "{out}");
        let image = image::open(here.path().join(name)).map(|image| image.into_rgba32f());
        let texel = |x: u32, y: u32| -> [f32; 4] {
            match &image {
                Ok(image) => image.get_pixel(x, y).0,
                Err(_) => exr_texel(&here.path().join(name), x as usize, y as usize),
            }
        };
        // The map does not repeat: the right edge takes the value of the right end, not of the left one.
        for (x, y) in [(0, 0), (5, 3), (15, 7), (18, 2), (31, 4)] {
            let place = 2.0 * (f64::from(x.min(15)) + 0.5) / 16.0;
            let depths = [1.0 + 0.5 * place, f64::max(1.5, 1.0 + 0.5 * place)];
            for (value, depth) in texel(x, y).iter().zip(depths) {
                let share = if word == "bright" { depth / scale } else { 1.0 - depth / scale };
                assert!((f64::from(*value) - share).abs() < 2e-5, "{name} ({x}, {y}): {value}, not {share}");
            }
        }
        // The printed settings can be pasted into a scene.
        let scene = format!(
            "[[light]]\ntype = 'directional'\ndirection = [0, 0, 1]\nirradiance = 1\n[camera]\nsize = [8, 8]\n\
             [[object]]\nmesh = 'skin.obj'\n[object.material.layers]\n{out}layer = [{{ sigma_s = 1, sigma_t = 2 }}, \
             {{ sigma_s = 1, sigma_t = 1 }}]\n"
        );
        std::fs::write(here.path().join("a.toml"), scene).unwrap();
        let (_, err) = good(&here, "render a.toml -o b.png --device cpu");
        assert!(!err.contains("depths lay above"), "{err}");
    }
}

fn exr_texel(path: &std::path::Path, x: usize, y: usize) -> [f32; 4] {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), vec![[0f32; 4]; size.area()]),
        |(width, pixels), at, (r, g, b, a): (f32, f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b, a],
    );
    let (width, pixels) = image.unwrap().layer_data.channel_data.pixels;
    pixels[y * width + x]
}

#[test]
fn an_inner_surface_that_lies_outside_is_told() {
    // Flesh encloses the skin: a downward ray meets its far wall from inside.
    let cube = |half: f64| -> String {
        let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half });
        let corners: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {}\n", z - 1.0)).collect();
        corners + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    };
    let (skin, large, small) = (square(0.0, 0.0, true), cube(5.0), cube(0.5));
    let here = folder(&[("skin.obj", &skin), ("large.obj", &large), ("small.obj", &small)]);
    let (_, err) = good(&here, "bake-layers skin.obj small.obj large.obj -o a.png --size 32x8");
    assert!(err.contains("large.obj: 128 of 128 rays meet it from behind") && !err.contains("small.obj:"), "{err}");
}

#[test]
fn what_cannot_be_baked_is_an_error() {
    let (skin, above, bare) = (square(0.0, 0.0, true), square(1.0, 0.0, false), square(0.0, 0.0, false));
    let here = folder(&[("skin.obj", &skin), ("above.obj", &above), ("bare.obj", &bare)]);
    let cases = [
        ("bake-layers skin.obj above.obj -o a.png", "no ray down from the outer surface meets an inner one"),
        ("bake-layers bare.obj above.obj -o a.png", "bare.obj"),
        ("bake-layers skin.obj gone.obj -o a.png", "gone.obj: there is no such mesh file"),
        (
            "bake-layers skin.obj above.obj -o a.jpg",
            "-o: a map's name says its format; found a.jpg; expected .png or .exr",
        ),
        ("bake-layers skin.obj above.obj -o a.png --size 0x9", "--size: not the size of a map; found 0x9"),
    ];
    for (line, message) in cases {
        bad(&here, line, 2, &[message]);
    }
}
