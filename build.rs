//! Compiles every `glsl/**/*.comp` to SPIR-V, and writes the GLSL form of `src/layout` for them to include. Kernels of
//! tests and benches go the same way, but not into the program: `OUT_DIR/tests-kernels-NAME.spv`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

#[path = "src/layout/mod.rs"]
mod layout;

/// Kernels that are no stage's: they are compiled, and only who names them holds them.
const OUTSIDE: [&str; 2] = ["tests/kernels", "bench/kernels"];

fn main() {
    println!("cargo::rerun-if-changed=glsl");
    println!("cargo::rerun-if-changed=src/layout");
    OUTSIDE.iter().for_each(|folder| println!("cargo::rerun-if-changed={folder}"));
    if let Err(message) = run() {
        println!("cargo::error={}", message.trim_end().replace('\n', "\ncargo::error="));
        process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let header = declarations();

    // Compile each shader beside its name.
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut table = String::from("pub(super) static SPIRV: &[(&str, &[u8])] = &[\n");
    let mut failures = String::new();
    for path in shaders(Path::new("glsl"))? {
        let name = path.strip_prefix("glsl").map_err(|e| e.to_string())?.with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        match compile(&compiler, &path, &header) {
            Ok(binary) => {
                let file = out.join(format!("{}.spv", name.replace('/', "-")));
                fs::write(&file, binary).map_err(|e| format!("{}: {e}", file.display()))?;
                let _ = writeln!(table, "    ({name:?}, include_bytes!({:?})),", file.display().to_string());
            }
            Err(message) => failures.push_str(&message),
        }
    }
    for folder in OUTSIDE.into_iter().filter(|folder| Path::new(folder).exists()) {
        for path in shaders(Path::new(folder))? {
            let name = path.with_extension("spv").to_string_lossy().replace(['/', '\\'], "-");
            match compile(&compiler, &path, &header) {
                Ok(binary) => fs::write(out.join(&name), binary).map_err(|e| format!("{name}: {e}"))?,
                Err(message) => failures.push_str(&message),
            }
        }
    }
    if !failures.is_empty() {
        return Err(failures);
    }
    table.push_str("];\n");
    fs::write(out.join("kernels.rs"), table).map_err(|e| e.to_string())
}

/// Every `.comp` file below `folder`, sorted.
fn shaders(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.is_dir() {
            found.extend(shaders(&path)?);
        } else if path.extension().is_some_and(|e| e == "comp") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Compiles one shader; a warning is an error. Messages carry file and line.
fn compile(compiler: &shaderc::Compiler, path: &Path, header: &str) -> Result<Vec<u8>, String> {
    let source = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_5);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(move |name, _, _, _| {
        if name == "layout.glsl" {
            return Ok(shaderc::ResolvedInclude { resolved_name: name.into(), content: header.into() });
        }
        let file = Path::new("glsl").join(name);
        fs::read_to_string(&file)
            .map(|content| shaderc::ResolvedInclude { resolved_name: file.display().to_string(), content })
            .map_err(|e| format!("{}: {e}", file.display()))
    });
    compiler
        .compile_into_spirv(&source, shaderc::ShaderKind::Compute, &path.display().to_string(), "main", Some(&options))
        .map(|artifact| artifact.as_binary_u8().to_vec())
        .map_err(|e| e.to_string())
}

/// The records and buffers of `src/layout` as GLSL.
fn declarations() -> String {
    let mut text = String::from(
        "#extension GL_EXT_scalar_block_layout : require\n\
         #define READS(name) READS_##name\n#define WRITES(name) WRITES_##name\n#define UPDATES(name) UPDATES_##name\n",
    );
    for record in layout::records() {
        let _ = write!(text, "struct {} {{", record.name);
        for (field, kind, _) in &record.fields {
            let _ = write!(text, " {kind} {field};");
        }
        text.push_str(" };\n");
    }
    for &slot in layout::SLOTS {
        let (spec, binding) = (slot.spec(), slot as usize);
        for (word, qualifier) in [("READS", "readonly"), ("WRITES", "writeonly"), ("UPDATES", "")] {
            let _ = writeln!(
                text,
                "#define {word}_{name} layout(set = 0, binding = {binding}, scalar) restrict {qualifier} \
                 buffer {name}_block {{ {kind} {name}[]; }};",
                name = spec.name,
                kind = spec.glsl,
            );
        }
    }
    text
}
