//! Includes of shaders are paths below `glsl`. A compiler that searches beside the including file first must find
//! nothing else there: a file that found itself would be included for ever.

use std::fs;
use std::path::Path;

/// The includes of a shader that name a file beside it.
fn beside(path: &Path, source: &str) -> Vec<String> {
    let folder = path.parent().unwrap();
    let names = source.lines().filter_map(|line| line.trim().strip_prefix("#include \"")?.strip_suffix('"'));
    let other = |name: &&str| folder != Path::new("glsl") && folder.join(name).exists();
    names.filter(other).map(|name| format!("{} includes {name}, which is beside it too", path.display())).collect()
}

#[test]
fn an_include_means_one_file() {
    let sources: Vec<_> = super::files("glsl", "comp").into_iter().chain(super::files("glsl", "glsl")).collect();
    let found: Vec<String> = sources.iter().flat_map(|path| beside(path, &fs::read_to_string(path).unwrap())).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    // The test sees what it looks for.
    assert_eq!(beside(Path::new("glsl/view/x.comp"), "#include \"shade.comp\"\n#include \"scan.glsl\"\n").len(), 1);
}
