//! A case as a folder: `replay.json`, `case.amber`, and raw files of little-endian words.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::json::{BindingFile, CaseFile, DispatchFile, PartFile, SCHEMA};
use super::{About, BITS, Bound, Case, Dispatch, Part, amber};
use crate::error::{Error, Input, Result};
use crate::gpu::{disassembled, interface, words_in};
use crate::measure::folder::{CASE, Folder};

/// Most bytes of `replay.json`.
const MOST_TEXT: u64 = 64 << 20;
/// Most bytes of another file: no binding is larger.
const MOST_BYTES: u64 = 1 << 32;

/// A kernel's name as that of a file: `transport-blocks-push`.
fn flat(kernel: &str) -> String {
    kernel.replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "-")
}

/// The names of the files of SPIR-V, by dispatch; dispatches of the same SPIR-V share one.
pub(super) fn modules(case: &Case) -> Vec<String> {
    let mut known: Vec<(&Dispatch, String)> = Vec::new();
    let mut names = Vec::new();
    for dispatch in &case.dispatches {
        let same = known.iter().find(|(other, _)| other.spirv == dispatch.spirv && other.kernel == dispatch.kernel);
        let name = same.map_or_else(
            || {
                let taken = known.iter().filter(|(other, _)| other.kernel == dispatch.kernel).count();
                let more = if taken > 0 { format!("-{taken}") } else { String::new() };
                format!("{}{more}", flat(&dispatch.kernel))
            },
            |(_, name)| name.clone(),
        );
        known.push((dispatch, name.clone()));
        names.push(name);
    }
    names
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

impl Case {
    /// Writes the case to this folder, whole or not at all; `key` is the argument that names it.
    pub fn write(&self, folder: &Path, key: &str) -> Result<()> {
        let folder = Folder::open(folder, &CASE, key)?;
        let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
        let mut put = |name: String, words: &[u32]| {
            files.insert(name.clone(), bytes(words));
            name
        };
        let mut parts = Vec::new();
        for (index, part) in self.buffers.iter().enumerate() {
            let writes = self.writes(index);
            let name = &part.name;
            let loose = part.allowed.iter().any(|allowed| *allowed != BITS);
            let allowed: Vec<u32> = part.allowed.iter().map(|allowed| allowed.to_bits()).collect();
            let kind = |float: bool| if float { "float" } else { "uint" };
            let element =
                part.words.iter().map(|(path, float)| format!("{} {path}", kind(*float)).trim_end().into()).collect();
            parts.push(PartFile {
                name: name.clone(),
                bytes: 4 * part.before.len() as u64,
                element,
                first: part.first,
                before: put(format!("{name}.before"), &part.before),
                expected: (writes || part.expected != part.before)
                    .then(|| put(format!("{name}.expected"), &part.expected)),
                allowed: loose.then(|| put(format!("{name}.allowed"), &allowed)),
                device: (writes && self.about.seconds.is_none()).then(|| put(format!("{name}.device"), &part.device)),
            });
        }
        let mut dispatches = Vec::new();
        for (dispatch, module) in self.dispatches.iter().zip(modules(self)) {
            files.insert(format!("{module}.spv"), bytes(&dispatch.spirv));
            files.insert(format!("{module}.spvasm"), disassembled(&dispatch.spirv).into_bytes());
            dispatches.push(self.dispatch_file(dispatch, &module));
        }
        files.insert("case.amber".into(), amber::script(self).into_bytes());
        let about = self.about.clone();
        let file = CaseFile {
            milkglass_case: SCHEMA,
            program: format!("milkglass {}", env!("CARGO_PKG_VERSION")),
            stage: about.stage,
            does: about.does,
            step: about.step,
            fixture: about.fixture,
            device: about.device,
            driver: about.driver,
            tolerance: about.tolerance,
            chosen: about.dispatches,
            fails: about.fails,
            seconds: about.seconds,
            buffers: parts,
            dispatches,
        };
        let text = serde_json::to_string_pretty(&file).map_err(|error| {
            Error::from(Input::new(format!("could not be written: {error}")).file(CASE.page.as_ref()))
        })?;
        folder.fill(&format!("{text}\n"), &files.into_iter().collect::<Vec<_>>())
    }

    /// A dispatch as the file has it.
    fn dispatch_file(&self, dispatch: &Dispatch, module: &str) -> DispatchFile {
        let bind = |b: &Bound| BindingFile {
            binding: b.number,
            buffer: self.buffers[b.buffer].name.clone(),
            bytes: b.bytes,
            writes: b.writes,
        };
        DispatchFile {
            kernel: dispatch.kernel.clone(),
            spirv: format!("{module}.spv"),
            constants: dispatch.constants.clone(),
            push_constants: dispatch.push.clone(),
            lanes: dispatch.lanes,
            groups: dispatch.groups,
            first_group: dispatch.first_group,
            bindings: dispatch.bindings.iter().map(bind).collect(),
        }
    }

    /// Reads the case of this folder.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(CASE.page);
        let text = read(&path, MOST_TEXT)?;
        let file: CaseFile = serde_json::from_slice(&text).map_err(|error| {
            let what = error.to_string();
            let what = what.rsplit_once(" at line ").map_or(what.as_str(), |(what, _)| what).to_string();
            Error::from(Input::new(what).file(&path).line(error.line()).expected("what `milkglass dump` writes"))
        })?;
        let fault = |key: &str, what: &str| Input::new(what).file(&path).key(key);
        if file.milkglass_case != SCHEMA {
            let fault = fault("milkglass_case", "this version of the format is not known");
            return Err(fault.found(file.milkglass_case).expected(SCHEMA).into());
        }
        if let Some(seconds) = file.seconds.filter(|seconds| !(0.001..=1e6).contains(seconds)) {
            return Err(fault("seconds", "not a time").found(seconds).expected("0.001 to 1e6").into());
        }
        let mut case = Self { about: about(&file), ..Self::default() };
        for part in file.buffers {
            let words = |name: &str| words(folder, &path, name, Some(part.bytes));
            let before = words(&part.before)?;
            let allowed = match &part.allowed {
                Some(name) => words(name)?.into_iter().map(f32::from_bits).collect(),
                None => vec![BITS; before.len()],
            };
            let expected = part.expected.as_ref().map_or_else(|| Ok(before.clone()), |name| words(name))?;
            let device = part.device.as_ref().map_or_else(|| Ok(before.clone()), |name| words(name))?;
            if case.buffers.iter().any(|known| known.name == part.name) {
                return Err(fault("buffers", "two have the same name").found(&part.name).into());
            }
            let mut words = Vec::new();
            for word in &part.element {
                let (kind, path) = word.split_once(' ').unwrap_or((word, ""));
                if !["float", "uint"].contains(&kind) {
                    let fault = fault("buffers.element", "not a word").found(word);
                    return Err(fault.expected("float or uint, and a path").into());
                }
                words.push((path.to_string(), kind == "float"));
            }
            case.buffers.push(Part { name: part.name, words, first: part.first, before, expected, allowed, device });
        }
        for dispatch in file.dispatches {
            let dispatch = case.read_dispatch(folder, dispatch)?;
            case.dispatches.push(dispatch);
        }
        if case.dispatches.is_empty() {
            return Err(fault("dispatches", "there is none").into());
        }
        Ok(case)
    }

    /// Reads a dispatch of the case in this folder, whose buffers are known.
    fn read_dispatch(&self, folder: &Path, dispatch: DispatchFile) -> Result<Dispatch> {
        let path = folder.join(CASE.page);
        let fault = |key: &str, what: &str| Input::new(what).file(&path).key(key);
        let spirv = words(folder, &path, &dispatch.spirv, None)?;
        let found = interface(&dispatch.kernel, &spirv)
            .map_err(|error| Error::from(Input::new(error.to_string()).file(&folder.join(&dispatch.spirv))))?;
        let mut bindings = Vec::new();
        for b in &dispatch.bindings {
            let index = self.buffers.iter().position(|part| part.name == b.buffer);
            let buffer = index.ok_or_else(|| fault("buffer", "there is no such buffer").found(&b.buffer))?;
            let whole = 4 * self.buffers[buffer].before.len() as u64;
            if b.bytes < 4 || b.bytes > whole {
                let fault = fault("bindings.bytes", "not a part of the buffer").found(b.bytes);
                return Err(fault.expected(format!("4 to {whole}")).into());
            }
            bindings.push(Bound { number: b.binding, buffer, bytes: b.bytes, writes: b.writes });
        }
        if let Some(lacks) = found.bindings.iter().find(|number| bindings.iter().all(|b| b.number != **number)) {
            return Err(fault("bindings", "the kernel binds a number that is not there").found(lacks).into());
        }
        for (key, given, taken) in [
            ("push_constants", 4 * dispatch.push_constants.len(), found.push_bytes as usize),
            ("constants", dispatch.constants.len(), found.constants),
        ] {
            if given != taken {
                let what = "not as many bytes, or constants, as the kernel takes";
                return Err(fault(key, what).found(given).expected(taken).into());
            }
        }
        let DispatchFile { kernel, constants, push_constants: push, lanes, groups, first_group, .. } = dispatch;
        Ok(Dispatch { kernel, spirv, constants, push, lanes, groups, first_group, bindings })
    }
}

fn about(file: &CaseFile) -> About {
    About {
        stage: file.stage.clone(),
        does: file.does.clone(),
        step: file.step.clone(),
        fixture: file.fixture.clone(),
        device: file.device.clone(),
        driver: file.driver.clone(),
        tolerance: file.tolerance.clone(),
        dispatches: file.chosen.clone(),
        fails: file.fails,
        seconds: file.seconds,
    }
}

/// The words of a file of the folder; `from` is the file that names it, `size` how many bytes it must have.
fn words(folder: &Path, from: &Path, name: &str, size: Option<u64>) -> Result<Vec<u32>> {
    if Path::new(name).file_name() != Some(name.as_ref()) {
        let fault = Input::new("not the name of a file").file(from).found(name);
        return Err(fault.expected("a file of the same folder").into());
    }
    let path = folder.join(name);
    let bytes = read(&path, MOST_BYTES)?;
    let found = bytes.len() as u64;
    if found == 0 || !found.is_multiple_of(4) || size.is_some_and(|size| size != found) {
        let expected = size.map_or("whole words".into(), |size| format!("{size} bytes, as {} says", from.display()));
        return Err(Input::new(format!("it has {found} bytes")).file(&path).expected(expected).into());
    }
    Ok(words_in(&bytes))
}

/// A plain file's bytes.
fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let fault = |what: String| Error::from(Input::new(format!("could not be read: {what}")).file(path));
    let known = fs::metadata(path).map_err(|error| fault(error.to_string()))?;
    if !known.is_file() {
        return Err(fault("not a plain file".into()));
    }
    if known.len() > most {
        return Err(fault(format!("it has {} bytes, at most {most} are read", known.len())));
    }
    fs::read(path).map_err(|error| fault(error.to_string()))
}
