//! The program says what the error estimate leaves out: borders of shadows within triangles, where there are any.

use crate::shell::{folder, good};
use exr::prelude::read_all_flat_layers_from_file;

/// A slab of milk in the sun; the second light only fills in.
const SLAB: &str = "[camera]\nposition = [0, 0, 60]\ntarget = [0, 0, 0]\nsize = [32, 24]\n\
                    [[object]]\nshape = 'slab'\ndetail = 8\nsize = 20\nmaterial = { preset = 'marble' }\n\
                    [[light]]\ntype = 'directional'\ndirection = [0.2, 0.3, 1]\nirradiance = 3\n\
                    [[light]]\ntype = 'environment'\nradiance = 1\nocclusion = 16\n";
/// An opaque plate above half of the slab.
const PLATE: &str = "[[object]]\nshape = 'slab'\ndetail = 4\nsize = 14\nposition = [3, 4, 12]\n\
                     material = { opaque = true }\n";
const WORDS: &str = "the error estimate leaves out the borders of shadows";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn borders_that_are_not_in_the_estimate_are_named() {
    let half = format!("{SLAB}{PLATE}");
    let here = folder(&[("half.toml", &half), ("open.toml", SLAB)]);
    for how in ["--device cpu", ""] {
        let said = |line: &str| good(&here, &format!("{line} {how}")).1.contains(WORDS);
        assert!(said("solve half.toml -o a.csv"), "{how}");
        assert!(said("render half.toml --aov -o a.exr"), "{how}");
        // No border, borders that are in the estimate, no shadow, no estimate.
        assert!(!said("solve open.toml -o a.csv"), "{how}");
        assert!(!said("solve half.toml --set transport.subdivide=1 -o a.csv"), "{how}");
        assert!(!said("solve half.toml --set light.0.shadows=false -o a.csv"), "{how}");
        assert!(!said("solve half.toml --set transport.scheme=links -o a.csv"), "{how}");
        assert!(!said("render half.toml -o a.exr"), "{how}");
    }
    let (_, err) = good(&here, "solve half.toml --verify 20 --device cpu");
    let number = err.lines().find(|line| line.contains(WORDS)).unwrap();
    let count: usize = number.split_whitespace().find_map(|word| word.parse().ok()).unwrap();
    // A rectangle's border on a grid of a few hundred triangles.
    assert!((5..150).contains(&count), "{number}");
}

#[test]
fn plan_and_layers_say_that_borders_are_left_out() {
    let half = format!("{SLAB}{PLATE}");
    let here = folder(&[("half.toml", &half)]);
    let planned = |sets: &str| good(&here, &format!("plan half.toml --aov {sets} --device cpu")).0;
    let words = "without borders of shadows within triangles";
    assert!(planned("").contains(words));
    assert!(!planned("--set transport.subdivide=1").contains(words));
    assert!(!planned("--set light.0.shadows=false").contains(words));
    let comment = |sets: &str| {
        good(&here, &format!("render half.toml --aov {sets} -o a.exr --device cpu"));
        let image = read_all_flat_layers_from_file(here.path().join("a.exr")).unwrap();
        let named = |name: &str| {
            let layer = image
                .layer_data
                .iter()
                .find(|layer| layer.attributes.layer_name.as_ref().is_some_and(|known| known == name));
            layer.unwrap().attributes.comments.as_ref().map(ToString::to_string)
        };
        assert_eq!(named("radiosity"), None);
        named("error_estimate")
    };
    assert!(comment("").unwrap().contains(words));
    assert_eq!(comment("--set transport.subdivide=1"), None);
}
