//! The sources of the program's kernels, and kernels given at run time that replace one of them.

mod adapt;

use std::borrow::Cow;
use std::io::Read as _;
use std::path::Path;

use super::choices::Optimization;
use super::extras::needed;
use super::reflect::{Reflected, SOURCES, kernel_names, reflect, words_of};
use super::spirv_module::{MAGIC, entry_points, whole, words_in};
use crate::error::{Error, Input, Result};
use crate::layout::{BUFFER_IDS, declarations};
use adapt::adapted;

pub use adapt::Given;

/// The GLSL of a kernel, `transport/blocks/push`, or of a file that kernels include, `dipole/derivatives.glsl`;
/// `layout.glsl` declares the records and buffers. None where there is no such source.
pub fn source(name: &str) -> Option<Cow<'static, str>> {
    if name == "layout.glsl" {
        return Some(declarations().into());
    }
    let file = |known: &str| known == name || known.strip_suffix(".comp") == Some(name);
    SOURCES.iter().find(|(known, _)| file(known)).map(|(_, text)| (*text).into())
}

/// The names that [`source`] knows.
pub fn sources() -> impl Iterator<Item = &'static str> {
    SOURCES.iter().map(|(name, _)| name.strip_suffix(".comp").unwrap_or(name)).chain(["layout.glsl"])
}

/// The kernels that a name stands for: the one of that name, or those that include the file of that name, directly or
/// through others. None for `layout.glsl`, which all include and which is not written by hand.
pub fn kernels_of(name: &str) -> Vec<&'static str> {
    kernel_names().filter(|kernel| *kernel == name || name.ends_with(".glsl") && includes(kernel, name)).collect()
}

/// Whether a source of the program includes this file.
fn includes(source_name: &str, file: &str) -> bool {
    let Some((_, text)) = SOURCES.iter().find(|(known, _)| known.strip_suffix(".comp").unwrap_or(known) == source_name)
    else {
        return false;
    };
    let included = text.lines().filter_map(|line| line.trim_start().strip_prefix("#include \"")?.split('"').next());
    file != "layout.glsl" && included.into_iter().any(|name| name == file || includes(name, file))
}

/// The SPIR-V of the kernels that a file is to replace, by their names: of the kernel `name`, or of all that include
/// the file `name`. Interfaces are checked against the kernels' and made to fit them, with these values for constants
/// of their own.
///
/// Includes are searched for beside the file, then among the program's own sources. Errors are the user's: they name
/// the file, and the line where the compiler names it.
pub fn replacements(name: &str, file: &Path, given: &Given) -> Result<Vec<(String, Vec<u32>)>> {
    let kernels = kernels_of(name);
    if kernels.is_empty() {
        let names: Vec<_> = kernel_names().filter(|known| !known.starts_with("measure/")).collect();
        // A stage's name alone stands for its first kernel.
        let part = names.iter().find(|known| known.split('/').any(|part| part == name));
        let alike = |known: &str| strsim::jaro_winkler(known, name);
        let near = part.or_else(|| names.iter().max_by(|a, b| alike(a).total_cmp(&alike(b))));
        let fault = Input::new("there is no such kernel").key("--replace").found(name);
        let like = near.map_or(String::new(), |near| format!("{near}, or another one that "));
        return Err(fault.expected(format!("{like}`milkglass shader` lists")).into());
    }
    let made = |kernel: &str| Ok((kernel.to_string(), replacement(kernel, name, file, given)?));
    kernels.into_iter().map(made).collect()
}

/// The SPIR-V of one of these kernels.
fn replacement(kernel: &str, name: &str, file: &Path, given: &Given) -> Result<Vec<u32>> {
    let unread = |error| Input::new(format!("the shader could not be read: {error}")).file(file);
    let words = match file.extension().is_some_and(|ending| ending == "spv") {
        true if kernel != name => {
            let fault = Input::new(format!("{name} is a part of kernels")).file(file).found("SPIR-V");
            return Err(fault.expected("its GLSL, as `milkglass shader` prints it").into());
        }
        true => module(file, &bytes(file).map_err(unread)?)?,
        false => compile(file, &read(file).map_err(unread)?, (kernel != name).then_some((kernel, name)))?,
    };
    let fault = |what: String| Error::from(Input::new(what).file(file));
    if let Err(capability) = needed(&words) {
        let known = "features that `milkglass` opens devices with: 8, 16 and 64-bit numbers, the Vulkan memory model";
        return Err(Input::new(format!(
            "it can't take the place of {kernel}: milkglass has no feature for its capability"
        ))
        .file(file)
        .found(capability)
        .expected(known)
        .into());
    }
    let new =
        reflect(kernel, &words).map_err(|error| fault(format!("it can't take the place of {kernel}: {error}")))?;
    let built_in = reflect(kernel, &words_of(kernel)?)?;
    let misfit = |what: String| Input::new(format!("it can't take the place of {kernel}: it {what}")).file(file);
    if let Some(what) = differs(&new, &built_in) {
        return Err(misfit(what).into());
    }
    let words = adapted(kernel, words, [&new, &built_in], given, &misfit)?;
    match reflect(kernel, &words)?.push_bytes {
        bytes if bytes > built_in.push_bytes => {
            let what = "has a push constant of which the program sets the first bytes only";
            Err(misfit(what.into())
                .expected(format!("members that end or begin at byte {}", built_in.push_bytes))
                .into())
        }
        _ => Ok(words),
    }
}

/// How the interface of a kernel differs from the built-in one's where it must not: it may bind fewer buffers, and only
/// read what the built-in one reads and writes.
fn differs(new: &Reflected, built_in: &Reflected) -> Option<String> {
    for access in &new.accesses {
        let binding = access.binding;
        let name =
            BUFFER_IDS.get(binding as usize).map_or_else(|| format!("binding {binding}"), |id| id.spec().name.into());
        let Some(known) = built_in.accesses.iter().find(|known| known.binding == binding) else {
            let names: Vec<_> = built_in
                .accesses
                .iter()
                .filter_map(|a| Some(BUFFER_IDS.get(a.binding as usize)?.spec().name))
                .collect();
            return Some(format!("binds {name}; the built-in one binds {}", names.join(", ")));
        };
        for (does, may, word, other) in
            [(access.reads, known.reads, "reads", "writes"), (access.writes, known.writes, "writes", "reads")]
        {
            if does && !may {
                return Some(format!("{word} {name}, which the built-in one only {other}"));
            }
        }
        if let (Some(new), Some(built_in)) = (new.strides.get(&binding), built_in.strides.get(&binding))
            && new != built_in
        {
            return Some(format!("takes elements of {name} to have {new} bytes; they have {built_in}"));
        }
    }
    None
}

/// Most bytes of a shader, or of a file that it includes; the program's own have a hundredth of that.
const MOST_TEXT: u64 = 1 << 20;
/// Most files that a shader includes, directly or through others.
#[cfg(feature = "shaderc")]
const MOST_INCLUDES: u32 = 256;

/// The bytes of a plain file, at most [`MOST_TEXT`].
fn bytes(file: &Path) -> std::result::Result<Vec<u8>, String> {
    let known = file.metadata().map_err(|error| error.to_string())?;
    if !known.is_file() {
        return Err("not a plain file".into());
    }
    let mut bytes = Vec::new();
    let source = std::fs::File::open(file).map_err(|error| error.to_string())?;
    source.take(MOST_TEXT + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MOST_TEXT {
        return Err(format!("it has {} bytes, at most {MOST_TEXT} are read", known.len()));
    }
    Ok(bytes)
}

/// The text of a plain file.
fn read(file: &Path) -> std::result::Result<String, String> {
    let text = String::from_utf8(bytes(file)?).map_err(|_| "stream did not contain valid UTF-8".to_string())?;
    if let Some(at) = text.find('\0') {
        let line = 1 + text[..at].matches('\n').count();
        return Err(format!("line {line} has a NUL byte, which no GLSL has"));
    }
    Ok(text)
}

/// The words of a module of SPIR-V.
fn module(file: &Path, bytes: &[u8]) -> Result<Vec<u32>> {
    let words = words_in(bytes);
    if !bytes.len().is_multiple_of(4) || words.first() != Some(&MAGIC) || !whole(&words) {
        let found = format!("{} bytes", bytes.len());
        return Err(Input::new("not a module of SPIR-V")
            .file(file)
            .found(found)
            .expected("what compilers write")
            .into());
    }
    match entry_points(&words).as_slice() {
        [only] if only == "main" => Ok(words),
        names => {
            let found = if names.is_empty() { "none".into() } else { names.join(", ") };
            Err(Input::new("its entry points").file(file).found(found).expected("a single one, main").into())
        }
    }
}

/// Compiles a kernel, or the kernel of the program that is named first with `text` in place of the file that is named
/// second.
#[cfg(feature = "shaderc")]
fn compile(file: &Path, text: &str, part: Option<(&str, &str)>) -> Result<Vec<u32>> {
    if part.is_none() && !text.lines().any(|line| line.trim_start().starts_with("#version")) {
        let fault = Input::new("the shader has no #version").file(file).line(1);
        return Err(fault.expected("#version 460 in its first line, as `milkglass shader` prints it").into());
    }
    let compiler = shaderc::Compiler::new().map_err(|error| Error::device("starting the shader compiler", error))?;
    let beside = file.parent().unwrap_or(Path::new(""));
    let included = std::cell::Cell::new(0);
    let include = |name: &str| {
        if part.is_some_and(|(_, part)| part == name) {
            return Ok((file.display().to_string(), text.to_string()));
        }
        let path = beside.join(name);
        included.set(included.get() + 1);
        if included.get() > MOST_INCLUDES {
            return Err(format!(
                "{} includes more than {MOST_INCLUDES} files: does one include itself?",
                file.display()
            ));
        }
        if path.is_file() {
            let content = read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            return Ok((path.display().to_string(), content));
        }
        let content = source(name).ok_or_else(|| {
            format!("{name} is neither beside {} nor built in; `milkglass shader` lists what is", file.display())
        })?;
        Ok((name.to_string(), content.into_owned()))
    };
    let level = shaderc::OptimizationLevel::Performance;
    let (whole, called) = match part.and_then(|(kernel, _)| Some((source(kernel)?, kernel.to_string()))) {
        Some(kernel) => kernel,
        None => (text.into(), file.display().to_string()),
    };
    super::compile::compile(&compiler, &whole, &called, (level, None), include)
        .map(|artifact| artifact.as_binary().to_vec())
        .map_err(|text| Input::new(format!("the shader does not compile\n{}", shortened(&text))).file(file).into())
}

/// The first lines of a compiler's messages and the last one, each once; one mistake may have thousands.
#[cfg(feature = "shaderc")]
fn shortened(text: &str) -> String {
    const MOST_LINES: usize = 20;
    let mut lines: Vec<&str> = text.lines().collect();
    lines.dedup();
    if lines.len() <= MOST_LINES {
        return lines.join("\n");
    }
    let (first, rest) = lines.split_at(MOST_LINES - 1);
    let last = rest.last().copied().unwrap_or_default();
    format!("{}\n... and {} more lines\n{last}", first.join("\n"), rest.len() - 1)
}

#[cfg(not(feature = "shaderc"))]
fn compile(file: &Path, _: &str, _: Option<(&str, &str)>) -> Result<Vec<u32>> {
    let what = "this build can't compile shaders: build milkglass with `--features shaderc` for --replace";
    Err(Input::new(what).file(file).into())
}

/// The SPIR-V of a kernel of the program, compiled anew with other aims, and without subgroup operations if `alone`.
#[cfg(feature = "shaderc")]
pub(super) fn compiled(kernel: &str, aim: Optimization, alone: bool) -> Result<Vec<u32>> {
    use std::collections::BTreeMap;
    use std::sync::{Mutex, PoisonError};
    // Devices are opened again and again to time them.
    static KNOWN: Mutex<BTreeMap<(String, Optimization, bool), Vec<u32>>> = Mutex::new(BTreeMap::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(words) = known.get(&(kernel.to_owned(), aim, alone)) {
        return Ok(words.clone());
    }
    let fault = |what: String| Error::device(format!("compiling kernel {kernel}"), what);
    let level = match aim {
        Optimization::Performance => shaderc::OptimizationLevel::Performance,
        Optimization::Size => shaderc::OptimizationLevel::Size,
        Optimization::Without => shaderc::OptimizationLevel::Zero,
    };
    let compiler = shaderc::Compiler::new().map_err(|error| fault(error.to_string()))?;
    let text = source(kernel).ok_or_else(|| fault("its source is not known".into()))?;
    let include = |name: &str| {
        let content = source(name).ok_or_else(|| format!("{name} is not built in"))?;
        Ok((name.to_string(), content.into_owned()))
    };
    let define = alone.then_some("WITHOUT_SUBGROUPS");
    let made = super::compile::compile(&compiler, &text, kernel, (level, define), include);
    let words = made.map_err(fault)?.as_binary().to_vec();
    known.insert((kernel.to_owned(), aim, alone), words.clone());
    Ok(words)
}

#[cfg(not(feature = "shaderc"))]
pub(super) fn compiled(kernel: &str, _: Optimization, _: bool) -> Result<Vec<u32>> {
    let what = "this build can't compile shaders: build milkglass with `--features shaderc`";
    Err(Error::device(format!("compiling kernel {kernel}"), what))
}
