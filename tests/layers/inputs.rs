//! Invalid layers, and layers that are accepted with a fallback.

use milkglass::internals::pipeline::plan::Options;

use super::{scene, session};
use crate::shell::{bad, folder, good};

const SCENE: &str = "[camera]\nsize = [16, 16]\n[[light]]\ntype = 'directional'\ndirection = [0, 0, 1]\nirradiance = 1\n\
                     [[object]]\nshape = 'slab'\ndetail = 2\nsize = 10\n[object.material.layers]\n";
const LAYER: &str = "{ sigma_s = 1, sigma_t = 2, g = 0.5, thickness = 1 }";
const BARE: &str = "{ sigma_s = 1, sigma_t = 2 }";

fn one(layer: &str) -> String {
    format!("layer = [{layer}]\n")
}

#[test]
fn what_cannot_be_is_an_error_of_file_line_and_key() {
    let maps =
        |maps: &str, layers: usize| format!("maps = {maps}\nscale = 1\nlayer = [{}]\n", vec![BARE; layers].join(", "));
    let cases = [
        (
            one(&LAYER.replace("2,", "0.5,")),
            "a.toml:12: object.0.material.layers.layer.0.sigma_t: extinction is less than",
        ),
        (one(&LAYER.replace("0.5", "1")), "object.0.material.layers.layer.0.g: out of range; found 1"),
        (one(&LAYER.replace("0.5", "-1.5")), "object.0.material.layers.layer.0.g: out of range; found -1.5"),
        (one(&LAYER.replace("1, sigma_t", "-1, sigma_t")), "object.0.material.layers.layer.0.sigma_s: out of range"),
        (one(&LAYER.replace("thickness = 1", "thickness = -1")), "layers.layer.0.thickness: out of range; found -1"),
        (one(&LAYER.replace("thickness = 1", "thickness = 0")), "layers.layer: the layers have no thickness"),
        (one(BARE), "layers.layer.0.thickness: missing: without maps every layer needs it"),
        (one(""), "layers.layer: there are no layers; found 0 layers; expected 1 to 16"),
        (
            format!("layer = [{}]\n", [LAYER; 17].join(", ")),
            "more layers than channels; found 17 layers; expected 1 to 16",
        ),
        (maps("['builtin:veins']", 5), "more layers than channels; found 5 layers; expected 1 to 4, four a map"),
        (maps("['builtin:veins', 'builtin:veins']", 3), "layers.maps: more maps than the layers need; found 2 maps"),
        (maps("[]", 3), "layers.maps: there are no maps; found an empty list"),
        (maps("['builtin:vein']", 3), "layers.maps: no map of this name is built in, did you mean `builtin:veins`?"),
        (maps("['gone.png']", 3), "gone.png: the map cannot be read"),
        (maps("['grey.png']", 2), "grey.png: more layers than channels; found 1 channels; expected 2, one a layer"),
        (maps("['flat.png']", 3), "layers.maps: the maps say that every layer lies at the surface"),
        (
            maps("['tall.png', 'flat.png']", 5),
            "layers.maps: maps of several sizes; found flat.png is 2 x 2; expected 1 x 2",
        ),
        (maps("['builtin:veins']", 3).replace("scale = 1\n", ""), "layers.scale: missing: the depth that"),
        (maps("['builtin:veins']", 3).replace("= 1\n", "= 0\n"), "layers.scale: out of range; found 0"),
        (maps("['builtin:veins']", 1).replace(BARE, LAYER), "layer.0.thickness: the maps say how thick a layer is"),
        (one(LAYER) + "wrap = 'clamp'\n", "layers.wrap: there are no maps"),
        (one(LAYER) + "samples = 0\n", "layers.samples: out of range; found 0; expected a whole number from 1 to 1000"),
        (one(LAYER) + "epsilon = 1\n", "layers.epsilon: out of range; found 1"),
        (one(LAYER) + "phase = 'shlick'\n", "unknown value, did you mean `schlick`?"),
        (one(LAYER) + "dpeth = 'dark'\n", "unknown key, did you mean `depth`?"),
    ];
    for (layers, message) in cases {
        let here = folder(&[("a.toml", &format!("{SCENE}{layers}"))]);
        image::GrayImage::from_pixel(2, 2, image::Luma([9])).save(here.path().join("grey.png")).unwrap();
        image::RgbaImage::from_pixel(2, 2, image::Rgba([0; 4])).save(here.path().join("flat.png")).unwrap();
        image::RgbaImage::from_pixel(1, 2, image::Rgba([9; 4])).save(here.path().join("tall.png")).unwrap();
        bad(&here, "render a.toml -o a.png --device cpu", 2, &["a.toml:", message]);
    }
}

#[test]
fn a_lamp_in_layers_alone_is_an_error() {
    let here = folder(&[("a.toml", &format!("{SCENE}layer = [{LAYER}]\n"))]);
    let lamp = |place: &str| format!("--set light.0={{type='point',position={place},intensity=1}}");
    let run = "render a.toml -o a.png --device cpu";
    let words =
        ["light.0.position: the light stands in the medium; found a light at [1, 0, 0]", "expected a place outside"];
    bad(&here, &format!("{run} {}", lamp("[1,0,0]")), 2, &words);
    // Nothing is inside an open surface, and light from below it does not enter.
    good(&here, &format!("{run} {} --set object.0.shape=plane", lamp("[0,-1,0]")));
}

/// All values of a picture of a slab with these layers under the sun, and the largest.
fn shown(layers: &str, sets: &[&str]) -> (Vec<f32>, f32) {
    let layers = format!("object.0.material.layers={{ samples = 9, layer = [{layers}] }}");
    let sun = "light=[{ type = 'directional', direction = [0.3, 1, 0.8], irradiance = 1 }]";
    let all = [&["object.0.detail=2", "camera.size=[16, 16]", "camera.background=0", sun, &layers], sets].concat();
    let picture = session(&scene("slab-layers", &all), Options::default()).picture().unwrap().pixels;
    let values: Vec<f32> = picture.into_iter().flatten().collect();
    let largest = values.iter().copied().fold(0.0, f32::max);
    (values, largest)
}

#[test]
fn a_layer_of_no_thickness_counts_for_nothing() {
    let thin = "{ sigma_s = 9, sigma_t = 9, thickness = 0 }";
    let (alone, largest) = shown(LAYER, &[]);
    assert!(largest > 0.0);
    for layers in [format!("{thin}, {LAYER}"), format!("{LAYER}, {thin}"), format!("{thin}, {LAYER}, {thin}, {thin}")] {
        let apart = alone.iter().zip(shown(&layers, &[]).0).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-5 * largest, "{layers}: {apart} of {largest}");
    }
}

#[test]
fn what_is_seen_at_a_grazing_angle_is_a_number() {
    // A plane from just above it, within 2 degrees, and from within it; a ball, whose silhouette has every angle.
    let above =
        |y: &str| format!("camera={{ position = [0, {y}, 9.9], target = [0, {y}, 0], fov = 4, size = [16, 16] }}");
    let round = "camera={ position = [0, 0, 40], target = [0, 0, 0], size = [16, 16] }".to_string();
    for (shape, camera, shows) in
        [("plane", above("0.02"), true), ("plane", above("0"), false), ("sphere", round, true)]
    {
        let (values, largest) = shown(LAYER, &[&format!("object.0.shape={shape}"), &camera]);
        assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0) && largest < 1.0, "{shape}: {largest}");
        assert!(largest > 0.0 || !shows, "{shape}");
    }
}

#[test]
fn a_mesh_needs_places_in_the_maps() {
    let mapped = format!("maps = ['builtin:veins']\nscale = 1\nlayer = [{BARE}]\n");
    let of_mesh = SCENE.replace("shape = 'slab'\ndetail = 2", "mesh = 'a.obj'") + &mapped;
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n";
    let without = format!("{corners}f 1 2 3\nf 2 4 3\n");
    let flat = format!("{corners}f 1/1 2/1 3/1\nf 2/2 4/2 3/2\n");
    let half = format!("{corners}f 1/1 2/2 3/3\nf 2/2 4/2 3/2\n");
    let run = "render a.toml -o a.png --device cpu";
    bad(&folder(&[("a.toml", &of_mesh), ("a.obj", &without)]), run, 2, &["a.obj", "material.layers.maps"]);
    let words = ["object.0.material.layers.maps: the mesh's texture coordinates lie on a line in every triangle"];
    bad(&folder(&[("a.toml", &of_mesh), ("a.obj", &flat)]), run, 2, &words);
    let (_, err) = good(&folder(&[("a.toml", &of_mesh), ("a.obj", &half)]), run);
    assert!(err.contains("layers: 1 of 2 triangles have no area in the maps: there depths do not vary"), "{err}");
    // Uniform layers need no texture coordinates.
    let even = of_mesh.replace(&mapped, &format!("layer = [{LAYER}]\n"));
    good(&folder(&[("a.toml", &even), ("a.obj", &without)]), run);
}

#[test]
fn depths_that_rise_are_brought_down_and_counted() {
    let here =
        folder(&[("a.toml", &format!("{SCENE}maps = ['a.png']\nscale = 1\nlayer = [{BARE}, {BARE}, {BARE}]\n"))]);
    image::RgbaImage::from_pixel(2, 2, image::Rgba([100, 50, 200, 0])).save(here.path().join("a.png")).unwrap();
    let (_, err) = good(&here, "render a.toml -o b.png --device cpu");
    assert!(err.contains("layers: 4 of 12 depths lay above the layer before and were brought down to it"), "{err}");
    // Inverted, the depths are 155, 205, 55.
    let (_, err) = good(&here, "render a.toml -o b.png --device cpu --set object.0.material.layers.depth=dark");
    assert!(err.contains("layers: 4 of 12 depths"), "{err}");
}

#[test]
fn channels_that_no_layer_uses_may_hold_anything() {
    let of =
        |layers: usize| format!("{SCENE}maps = ['a.exr']\nscale = 1\nlayer = [{}]\n", vec![BARE; layers].join(", "));
    let here = folder(&[("a.toml", &of(2)), ("b.toml", &of(3))]);
    let texel = |_, _| (0.25f32, 0.5f32, f32::NAN);
    exr::prelude::write_rgb_file(here.path().join("a.exr"), 3, 2, texel).unwrap();
    good(&here, "render a.toml -o b.png --device cpu");
    bad(&here, "render b.toml -o c.png --device cpu", 2, &["layers.maps", "is no share of a depth", "NaN"]);
}

#[test]
fn other_keys_beside_layers() {
    let here = folder(&[("a.toml", &format!("{SCENE}layer = [{LAYER}]\n"))]);
    let run = "render a.toml -o a.png --device cpu --set object.0.material";
    for set in [".albedo=0.2", ".preset=marble", ".reflection=phong", ".opaque=true", ".layers.fresnel=true"] {
        good(&here, &format!("{run}{set}"));
    }
    let words = ["two_sided: a material of layers alone has no such key", "found no sigma_s_prime and sigma_a"];
    bad(&here, &format!("{run}.two_sided=true"), 2, &words);
    let here = folder(&[("a.toml", &format!("{SCENE}maps = ['builtin:veins']\nscale = 1\nlayer = [{BARE}]\n"))]);
    let words = ["object.0.material.layers.wrap: texture and maps go on beyond their edges in different ways"];
    let sets = ".texture=builtin:tiles --set object.0.material.layers.wrap=mirror";
    bad(&here, &format!("{run}{sets}"), 2, &words);
}
