//! Puts the kernels into the program: every `glsl/**/*.comp` as SPIR-V, with the GLSL form of `src/layout` for them
//! to include, and every source; those that share values in a subgroup also without that. Kernels of tests and
//! benches are only compiled: `OUT_DIR/tests-kernels-NAME.spv`.
//!
//! SPIR-V comes from the folder `spirv`, which a published package has, where it was made from these very sources;
//! else from the program `glslc`; with the feature `build-from-source`, from the shaderc that cargo builds.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Mutex;
use std::{env, fs, thread};

#[cfg(feature = "build-from-source")]
#[path = "src/gpu/compile.rs"]
mod compile;
#[path = "src/layout/mod.rs"]
mod layout;

/// Kernels that belong to no stage: they are compiled but not embedded.
const OUTSIDE: [&str; 2] = ["tests/kernels", "bench/kernels"];
/// A published package's SPIR-V, and the hash of the sources that it was compiled from.
const SHIPPED: &str = "spirv";
/// The macro that has kernels do without subgroup operations: see `glsl/shuffle.glsl`.
const WITHOUT_SUBGROUPS: &str = "WITHOUT_SUBGROUPS";
/// The static libraries of glslang and SPIRV-Tools that Debian's `libshaderc_combined.a` needs and does not contain, in
/// link order.
const PARTS: [&str; 9] = [
    "SPIRV",
    "glslang",
    "MachineIndependent",
    "GenericCodeGen",
    "OSDependent",
    "OGLCompiler",
    "HLSL",
    "SPIRV-Tools-opt",
    "SPIRV-Tools",
];

fn main() {
    // All of `src`, so that the commit is named anew when the program changes, but not for a commit alone.
    for input in ["build.rs", "Cargo.toml", "Cargo.lock", "glsl", "src", SHIPPED].into_iter().chain(OUTSIDE) {
        if Path::new(input).exists() {
            println!("cargo::rerun-if-changed={input}");
        }
    }
    println!("cargo::rerun-if-env-changed=GLSLC");
    println!("cargo::rerun-if-env-changed=VULKAN_SDK");
    name_commit();
    link_shaderc();
    if let Err(message) = run() {
        println!("cargo::error={}", message.trim_end().replace('\n', "\ncargo::error="));
        process::exit(1);
    }
}

/// Tells the program its commit, which results name: `MILKGLASS_COMMIT`, else what git says where this is the root of a
/// checkout, with a plus sign where sources differ from that commit.
fn name_commit() {
    println!("cargo::rerun-if-env-changed=MILKGLASS_COMMIT");
    if env::var_os("MILKGLASS_COMMIT").is_some() {
        return;
    }
    let git = |words: &[&str]| {
        let run = process::Command::new("git").args(words).output().ok().filter(|run| run.status.success())?;
        Some(String::from_utf8(run.stdout).ok()?.trim().to_string())
    };
    // A package that lies in another repository is not of its commit.
    let Some("") = git(&["rev-parse", "--show-prefix"]).as_deref() else { return };
    let Some(commit) = git(&["rev-parse", "HEAD"]).filter(|_| Path::new(".git").exists()) else { return };
    let changes = git(&["status", "--porcelain", "--", "src", "glsl", "build.rs", "Cargo.toml", "Cargo.lock"]);
    let mark = if changes.is_none_or(|changes| changes.is_empty()) { "" } else { "+" };
    println!("cargo::rustc-env=MILKGLASS_COMMIT={commit}{mark}");
}

/// A kernel to compile: its GLSL, a macro to define, and the SPIR-V file.
struct Job {
    source: PathBuf,
    define: Option<&'static str>,
    target: PathBuf,
}

fn run() -> Result<(), String> {
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let header = layout::declarations();
    fs::write(out.join("layout.glsl"), &header).map_err(|e| format!("layout.glsl: {e}"))?;
    let sources = files(Path::new("glsl"), &["comp", "glsl"])?;
    let kernels: Vec<&PathBuf> = sources.iter().filter(|path| path.extension().is_some_and(|e| e == "comp")).collect();

    let mut alone = Vec::new();
    for path in &kernels {
        alone.extend(read(path)?.contains("#include \"shuffle.glsl\"").then_some(*path));
    }

    // Take the SPIR-V that was shipped, or compile.
    let hash = hash(&sources, &header)?;
    let shipped = fs::read_to_string(Path::new(SHIPPED).join("sources")).is_ok_and(|known| known.trim() == hash);
    let folder = if shipped { fs::canonicalize(SHIPPED).map_err(|e| e.to_string())? } else { out.clone() };
    let mut jobs: Vec<Job> = Vec::new();
    if !shipped {
        let job = |path: &Path, define, target| Job { source: path.into(), define, target: out.join(target) };
        jobs.extend(kernels.iter().map(|path| job(path, None, binary(path))));
        jobs.extend(alone.iter().map(|path| job(path, Some(WITHOUT_SUBGROUPS), alone_binary(path))));
        fs::write(out.join("sources"), &hash).map_err(|e| e.to_string())?;
    }
    let mut all = sources.clone();
    for outside in OUTSIDE.into_iter().filter(|outside| Path::new(outside).exists()) {
        let name = |path: &Path| path.with_extension("spv").to_string_lossy().replace(['/', '\\'], "-");
        for path in files(Path::new(outside), &["comp"])? {
            all.push(path.clone());
            jobs.push(Job { target: out.join(name(&path)), define: None, source: path });
        }
    }
    // This script also runs when Rust files change: then what it has compiled before is still right.
    let scripts = [include_str!("build.rs"), include_str!("src/gpu/compile.rs")].concat();
    let made_of = self::hash(&all, &format!("{header}{scripts}{shipped}{}", compiler()))?;
    let (note, there) = (out.join("made-of"), jobs.iter().all(|job| job.target.exists()));
    if !there || fs::read_to_string(&note).ok().as_deref() != Some(&made_of) {
        // Until all are made, they are a mixture of old and new ones.
        let _ = fs::remove_file(&note);
        compile_all(jobs, &out, &header)?;
        fs::write(&note, made_of).map_err(|e| e.to_string())?;
    }

    // Tables of the binaries by name, and one of the sources by path.
    let mut table = String::new();
    for (name, kernels, file_of) in
        [("SPIRV", &kernels, binary as fn(&Path) -> String), ("SPIRV_WITHOUT_SUBGROUPS", &alone, alone_binary)]
    {
        let _ = writeln!(table, "pub(super) static {name}: &[(&str, &[u8])] = &[");
        for path in kernels {
            let file = folder.join(file_of(path)).display().to_string();
            let _ = writeln!(table, "    ({:?}, include_bytes!({file:?})),", inner(&path.with_extension("")));
        }
        table.push_str("];\n");
    }
    table.push_str("pub(super) static SOURCES: &[(&str, &str)] = &[\n");
    let here = env::current_dir().map_err(|e| e.to_string())?;
    for path in &sources {
        let _ = writeln!(table, "    ({:?}, include_str!({:?})),", inner(path), here.join(path).display().to_string());
    }
    table.push_str("];\n");
    fs::write(out.join("kernels.rs"), table).map_err(|e| e.to_string())
}

/// A path below `glsl`, with slashes.
fn inner(path: &Path) -> String {
    path.strip_prefix("glsl").unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// The file name of a kernel's SPIR-V.
fn binary(path: &Path) -> String {
    format!("{}.spv", inner(&path.with_extension("")).replace('/', "-"))
}

/// The same, of the kernel without subgroup operations.
fn alone_binary(path: &Path) -> String {
    binary(path).replace(".spv", ".without-subgroups.spv")
}

/// FNV-1a over all sources: shipped SPIR-V that was made from others is not used.
fn hash(sources: &[PathBuf], header: &str) -> Result<String, String> {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |text: &str| {
        for byte in text.bytes().filter(|byte| *byte != b'\r').chain([0]) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    add(header);
    for path in sources {
        add(&inner(path));
        add(&read(path)?);
    }
    Ok(format!("{hash:016x}"))
}

/// Compiles these kernels, on as many threads as cargo allows.
fn compile_all(jobs: Vec<Job>, out: &Path, header: &str) -> Result<(), String> {
    let threads = env::var("NUM_JOBS").ok().and_then(|n| n.parse().ok()).unwrap_or(2_usize).min(jobs.len());
    let (jobs, failures) = (Mutex::new(VecDeque::from(jobs)), Mutex::new(Vec::new()));
    let next = || jobs.lock().ok().and_then(|mut jobs| jobs.pop_front());
    let work = || {
        while let Some(job) = next() {
            if let (Err(message), Ok(mut failures)) = (compile_one(&job, out, header), failures.lock()) {
                failures.push(message);
            }
        }
    };
    thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    let failures = failures.into_inner().map_err(|e| e.to_string())?;
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n")) }
}

/// Compiles one kernel with `glslc`, with the options of `src/gpu/compile.rs`.
#[cfg(not(feature = "build-from-source"))]
fn compile_one(job: &Job, out: &Path, _: &str) -> Result<(), String> {
    let glslc = glslc();
    let includes = [Path::new("-Iglsl").to_path_buf(), format!("-I{}", out.display()).into()];
    let run = process::Command::new(&glslc)
        .args(["-fshader-stage=compute", "--target-env=vulkan1.2", "--target-spv=spv1.5", "-O", "-g", "-Werror"])
        .args(includes)
        .args(job.define.map(|name| format!("-D{name}")))
        .arg(&job.source)
        .arg("-o")
        .arg(&job.target)
        .output();
    match run {
        Ok(run) if run.status.success() => Ok(()),
        Ok(run) => Err(String::from_utf8_lossy(&run.stderr).into_owned()),
        Err(error) => Err(format!(
            "{}: {error}. Kernels are compiled by glslc, of the package glslc (Debian, Ubuntu, Fedora), shaderc (Arch, \
             Homebrew) or the Vulkan SDK; GLSLC=PATH names another one. Without it: --features build-from-source.",
            glslc.display()
        )),
    }
}

/// The compiler: `GLSLC`, or that of the Vulkan SDK, or the one that the path finds.
#[cfg(not(feature = "build-from-source"))]
fn glslc() -> PathBuf {
    let sdk = || Some(PathBuf::from(env::var_os("VULKAN_SDK")?).join("bin/glslc")).filter(|path| path.exists());
    env::var_os("GLSLC").map(PathBuf::from).or_else(sdk).unwrap_or_else(|| "glslc".into())
}

/// Which compiler it is.
#[cfg(not(feature = "build-from-source"))]
fn compiler() -> String {
    let run = process::Command::new(glslc()).arg("--version").output();
    format!("{} {:?}", glslc().display(), run.map(|run| run.stdout).ok())
}

/// Which compiler it is: the crate's, whose version is in the lock file.
#[cfg(feature = "build-from-source")]
fn compiler() -> String {
    "shaderc".into()
}

/// Compiles one kernel with the shaderc that cargo built.
#[cfg(feature = "build-from-source")]
fn compile_one(job: &Job, _: &Path, header: &str) -> Result<(), String> {
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let include = |name: &str| {
        if name == "layout.glsl" {
            return Ok((name.to_string(), header.to_string()));
        }
        let file = Path::new("glsl").join(name);
        read(&file).map(|content| (file.display().to_string(), content))
    };
    let (name, level) = (job.source.display().to_string(), shaderc::OptimizationLevel::Performance);
    let words = compile::compile(&compiler, &read(&job.source)?, &name, (level, job.define), include)?;
    fs::write(&job.target, words.as_binary_u8()).map_err(|e| format!("{}: {e}", job.target.display()))
}

/// Links what Debian's static shaderc lacks. `+whole-archive` has the linker take all of shaderc itself before the
/// crate `shaderc-sys` names it, so that the parts it needs follow it, in this crate and in every one that depends on
/// it. Where shaderc is whole, or built from source, nothing is to be done.
fn link_shaderc() {
    let set = |name: &str| env::var_os(name).is_some();
    let elsewhere = ["CARGO_FEATURE_BUILD_FROM_SOURCE", "SHADERC_LIB_DIR", "VULKAN_SDK"].into_iter().any(set);
    if !set("CARGO_FEATURE_SHADERC") || elsewhere {
        return;
    }
    let arch = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let folder = PathBuf::from(format!("/usr/lib/{arch}-linux-gnu"));
    let archive = |name: &str| folder.join(format!("lib{name}.a")).exists();
    if !archive("shaderc_combined") || !archive("MachineIndependent") {
        return;
    }
    println!("cargo::rustc-link-search=native={}", folder.display());
    println!("cargo::rustc-link-lib=static:+whole-archive,-bundle=shaderc_combined");
    for part in PARTS.into_iter().filter(|part| archive(part)) {
        println!("cargo::rustc-link-lib=static:-bundle={part}");
    }
    println!("cargo::rustc-link-lib=stdc++");
}

/// The text of a file.
fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Every file below `folder` with one of these endings, sorted.
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
