//! What shaders rely on.

use std::fs;

use super::{files, words};

/// Subgroups are used where `shuffle.glsl` grants them, and there is a module without them for devices that do not. Of
/// `asinh` Vulkan promises only a formula that cancels for negative numbers.
#[test]
fn shaders_do_not_rely_on_what_devices_do_not_promise() {
    let mut including = Vec::new();
    for path in [files("glsl", "comp"), files("glsl", "glsl")].concat() {
        let source = fs::read_to_string(&path).unwrap();
        let own = path.strip_prefix("glsl").unwrap().with_extension("").to_string_lossy().into_owned();
        including.extend(source.contains("#include \"shuffle.glsl\"").then_some(own.clone()));
        let subgroups =
            words(&source).into_iter().find(|word| word.starts_with("gl_Subgroup") || word.starts_with("subgroup"));
        let probes = own == "shuffle" || own == "measure/probe";
        assert!(probes || subgroups.is_none(), "{}: {subgroups:?} outside shuffle.glsl", path.display());
        assert!(!words(&source).contains("asinh"), "{}: asinh", path.display());
    }
    let alone: Vec<&str> = milkglass::internals::gpu::kernels_without_subgroups().collect();
    assert_eq!(alone, including);
}
