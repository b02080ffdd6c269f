//! A crate of its own that depends on milkglass, in a folder outside the checkout, with the front page's example: built
//! and run by path with the default features; checked without them, and from the published package where there is no
//! shader compiler.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The example of the crate's front page.
fn example() -> String {
    let page = fs::read_to_string("src/lib.rs").unwrap();
    let lines =
        page.lines().map_while(|line| line.strip_prefix("//!")).map(|line| line.strip_prefix(' ').unwrap_or(line));
    let code: Vec<&str> =
        lines.skip_while(|line| !line.starts_with("```")).skip(1).take_while(|line| !line.starts_with("```")).collect();
    assert!((8..=12).contains(&code.len()), "the front page's example has {} lines", code.len());
    code.join("\n")
}

/// Runs a program; fails with what it printed, also if the compiler warns.
fn succeed(command: &mut Command) -> String {
    let done = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = [&done.stdout, &done.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    let good = done.status.success() && !text[1].contains("warning");
    assert!(good, "{command:?}\n{}\n{}", text[0], text[1]);
    text[0].clone()
}

/// Dependencies as this crate has them, so that they are built already; milkglass unoptimized, since the test asks only
/// whether it builds and links.
const PROFILE: &str = "[profile.release]\nlto = \"off\"\n\n[profile.release.package.milkglass]\nopt-level = 0\n";

/// Cargo's target folder.
fn target() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap()
}

/// Lines of a manifest: the dependencies that milkglass does not always have. A crate that has them, too, shares all
/// builds with the tests; without them the features of many crates differ, so that these would be built once more. A
/// crate that is only checked goes without, so that a feature that milkglass forgets to ask for is missing there.
fn shared() -> String {
    let manifest = fs::read_to_string("Cargo.toml").unwrap();
    let (_, of_tests) = manifest.split_once("[dev-dependencies]\n").unwrap();
    let of_tests = of_tests.lines().take_while(|line| !line.is_empty());
    let window = ["ash-window", "egui", "winit"];
    let of_features =
        manifest.lines().filter(|line| line.contains(", optional = true") && !line.starts_with("shaderc"));
    let built = of_features.filter(|line| cfg!(feature = "window") || !window.iter().any(|one| line.starts_with(one)));
    built.chain(of_tests).map(|line| line.replace(", optional = true", "") + "\n").collect()
}

/// What is done with a crate that depends on milkglass.
#[derive(Clone, Copy, PartialEq)]
enum Done {
    /// Built and run: it links, and renders.
    Run,
    /// Checked: all that it names exists. It would link nothing beyond the one that is run.
    Checked,
}

/// Makes a crate of the example that depends on milkglass in `source` with this addition to the line of the dependency.
/// Returns the names of the crates that are built into it.
fn depends(source: &Path, addition: &str, settings: &[(&str, &str)], done: Done) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = source.display();
    let manifest = format!(
        "[package]\nname = \"dependent\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
         [dependencies]\nmilkglass = {{ path = \"{path}\"{addition} }}\n{}\n[workspace]\n{PROFILE}",
        if done == Done::Run { shared() } else { String::new() }
    );
    fs::create_dir(folder.path().join("src")).unwrap();
    fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
    fs::write(folder.path().join("src/main.rs"), example()).unwrap();
    // The versions that milkglass is tested with.
    fs::copy("Cargo.lock", folder.path().join("Cargo.lock")).unwrap();

    let cargo = || {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(&folder).env("CARGO_TARGET_DIR", target());
        cargo.env_remove("RUSTFLAGS").env_remove("RUSTC_BOOTSTRAP").envs(settings.iter().copied());
        cargo
    };
    if done == Done::Run {
        succeed(cargo().args(["run", "--release", "--quiet"]));
        let size = fs::metadata(folder.path().join("lotus.png")).unwrap().len();
        assert!(size > 10_000, "a picture of {size} bytes");
    } else {
        succeed(cargo().args(["check", "--release", "--quiet"]));
    }
    let tree = succeed(cargo().args([
        "tree",
        "--package",
        "milkglass",
        "--edges",
        "normal",
        "--prefix",
        "none",
        "--format",
        "{p}",
    ]));
    let mut names: Vec<String> = tree.lines().filter_map(|line| Some(line.split(' ').next()?.to_string())).collect();
    names.sort();
    names.dedup();
    names
}

/// The package, unpacked.
fn package(folder: &Path) -> PathBuf {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/package");
    let file = succeed(Command::new(script).arg(folder).arg(env!("OUT_DIR")));
    let file = file.trim();
    // The registry takes 10 MB. Most of it is SPIR-V, which has its GLSL text for debuggers.
    let size = fs::metadata(file).unwrap().len();
    assert!(size < 6_000_000, "the package is too large to publish: {size} bytes");
    succeed(Command::new("tar").args(["-xzf", file, "-C"]).arg(folder));
    let name = Path::new(file).file_name().unwrap().to_string_lossy();
    folder.join(name.strip_suffix(".crate").unwrap())
}

#[test]
#[ignore = "slow: builds the library once and checks it once"]
fn a_crate_elsewhere_renders_a_picture() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let whole = depends(here, "", &[], Done::Run);
    let lean = depends(here, ", default-features = false", &[], Done::Checked);
    for own in ["clap", "indicatif", "plotters", "csv", "shaderc"] {
        assert!(!lean.iter().any(|name| name == own), "a library without the command line builds {own}");
        assert!(whole.iter().any(|name| name == own), "{own} is no dependency any more: take it off this list");
    }
    println!("crates: {} with the command line, {} without", whole.len(), lean.len());
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn the_package_needs_no_shader_compiler() {
        let folder = tempfile::tempdir().unwrap();
        let source = package(folder.path());
        assert!(!source.join("tests").exists() && source.join("spirv/sources").exists());
        let none = [("GLSLC", "/no/such/compiler")];
        depends(&source, ", default-features = false", &none, Done::Checked);

        // SPIR-V whose source has changed is not used.
        let kernel = source.join("glsl/invocation.glsl");
        fs::write(&kernel, fs::read_to_string(&kernel).unwrap() + "\n// Changed.\n").unwrap();
        let build = Command::new(env!("CARGO"))
            .args(["check", "--release", "--quiet", "--lib", "--no-default-features", "--target-dir"])
            .arg(target())
            .current_dir(&source)
            .env_remove("RUSTC_BOOTSTRAP")
            .envs(none)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&build.stderr);
        assert!(!build.status.success() && said.contains("/no/such/compiler"), "{said}");
    }
}
