//! What shaders rely on of devices, and what dependencies rely on of Rust.

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

mod rare {
    /// Clippy (`incompatible_msrv`) checks what the code itself calls.
    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn no_dependency_needs_a_newer_rust() {
        // 1.89 is 1.89.0.
        let version = |text: &str| -> Vec<u32> {
            let mut parts: Vec<u32> = text.split('.').map(|part| part.parse().unwrap()).collect();
            parts.resize(3, 0);
            parts
        };
        let arguments =
            ["metadata", "--format-version", "1", "--locked", "--filter-platform", "x86_64-unknown-linux-gnu"];
        let done = std::process::Command::new(env!("CARGO")).args(arguments).output().unwrap();
        let all: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        let own = version(env!("CARGO_PKG_RUST_VERSION"));
        let packages = all["packages"].as_array().unwrap();
        assert!(packages.len() > 50, "{}", packages.len());
        for package in packages {
            if let Some(needed) = package["rust_version"].as_str() {
                assert!(version(needed) <= own, "{} needs Rust {needed}", package["name"]);
            }
        }
    }
}
