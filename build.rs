//! Compiles every `glsl/**/*.comp` to SPIR-V and embeds the binaries and sources in the program; shaders can include
//! the GLSL form of `src/layout` as `layout.glsl`. Kernels of tests and benches are only compiled:
//! `OUT_DIR/tests-kernels-NAME.spv`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

#[path = "src/gpu/compile.rs"]
mod compile;
#[path = "src/layout/mod.rs"]
mod layout;

/// Folders of kernels that belong to no stage; they stay out of the table and are included by path.
const OUTSIDE: [&str; 2] = ["tests/kernels", "bench/kernels"];

fn main() {
    println!("cargo::rerun-if-changed=glsl");
    println!("cargo::rerun-if-changed=src/layout");
    println!("cargo::rerun-if-changed=src/gpu/compile.rs");
    OUTSIDE.iter().for_each(|folder| println!("cargo::rerun-if-changed={folder}"));
    if let Err(message) = run() {
        println!("cargo::error={}", message.trim_end().replace('\n', "\ncargo::error="));
        process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let header = layout::declarations();

    // Compile each shader, and list the binaries by name.
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut table = String::from("pub(super) static SPIRV: &[(&str, &[u8])] = &[\n");
    let mut failures = String::new();
    for path in files(Path::new("glsl"), &["comp"])? {
        let name = path.strip_prefix("glsl").map_err(|e| e.to_string())?.with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        match compiled(&compiler, &path, &header) {
            Ok(binary) => {
                let file = out.join(format!("{}.spv", name.replace('/', "-")));
                fs::write(&file, binary).map_err(|e| format!("{}: {e}", file.display()))?;
                let _ = writeln!(table, "    ({name:?}, include_bytes!({:?})),", file.display().to_string());
            }
            Err(message) => failures.push_str(&message),
        }
    }
    for folder in OUTSIDE.into_iter().filter(|folder| Path::new(folder).exists()) {
        for path in files(Path::new(folder), &["comp"])? {
            let name = path.with_extension("spv").to_string_lossy().replace(['/', '\\'], "-");
            match compiled(&compiler, &path, &header) {
                Ok(binary) => fs::write(out.join(&name), binary).map_err(|e| format!("{name}: {e}"))?,
                Err(message) => failures.push_str(&message),
            }
        }
    }
    if !failures.is_empty() {
        return Err(failures);
    }
    table.push_str("];\n");

    // List each source by path.
    table.push_str("pub(super) static SOURCES: &[(&str, &str)] = &[\n");
    let here = env::current_dir().map_err(|e| e.to_string())?;
    for path in files(Path::new("glsl"), &["comp", "glsl"])? {
        let name = path.strip_prefix("glsl").map_err(|e| e.to_string())?.to_string_lossy().replace('\\', "/");
        let _ = writeln!(table, "    ({name:?}, include_str!({:?})),", here.join(&path).display().to_string());
    }
    table.push_str("];\n");
    fs::write(out.join("kernels.rs"), table).map_err(|e| e.to_string())
}

/// All files below `folder` with one of these extensions, sorted.
fn files(folder: &Path, endings: &[&str]) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.is_dir() {
            found.extend(files(&path, endings)?);
        } else if path.extension().is_some_and(|e| endings.iter().any(|ending| e == *ending)) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Compiles one shader.
fn compiled(compiler: &shaderc::Compiler, path: &Path, header: &str) -> Result<Vec<u8>, String> {
    let source = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let include = |name: &str| {
        if name == "layout.glsl" {
            return Ok(shaderc::ResolvedInclude { resolved_name: name.to_string(), content: header.to_string() });
        }
        let file = Path::new("glsl").join(name);
        let content = fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(shaderc::ResolvedInclude { resolved_name: file.display().to_string(), content })
    };
    compile::compile(compiler, &source, &path.display().to_string(), include)
        .map(|artifact| artifact.as_binary_u8().to_vec())
}
