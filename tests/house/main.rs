//! Rules of the code base, checked on its sources: which module may use which, where `ash` and `unsafe` may appear,
//! which shader belongs to which stage.

use std::fs;
use std::path::{Path, PathBuf};

mod cycles;
mod includes;
mod promises;
mod twins;

/// The modules from top to bottom; a module may use those below it.
const FLOORS: &[&[&str]] = &[
    &["main"],
    &["cli"],
    &["guide", "internals"],
    &["measure"],
    &["session"],
    &["prepare"],
    &["pipeline"],
    &["layers", "shading", "transport", "view"],
    &["dipole"],
    &["lighting"],
    &["geometry"],
    &["state"],
    &["gpu", "hierarchy", "scene"],
    &["layout"],
    &["error", "phases"],
];

/// All files with this extension below a folder, sorted.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    fn visit(folder: &Path, ending: &str, out: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                visit(&path, ending, out);
            } else if path.extension().is_some_and(|e| e == ending) {
                out.push(path);
            }
        }
    }
    let mut out = Vec::new();
    visit(Path::new(folder), ending, &mut out);
    out.sort();
    assert!(!out.is_empty(), "no .{ending} below {folder}");
    out
}

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// The modules named by `crate::MODULE` or `milkglass::MODULE` in a source, comments excluded.
fn uses(source: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in source.lines().filter(|line| !line.trim_start().starts_with("//")) {
        for start in ["crate::", "milkglass::"] {
            for (at, _) in line.match_indices(start) {
                let rest = &line[at + start.len()..];
                let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
                found.push(rest[..end].to_string());
            }
        }
    }
    found
}

/// The uses in a file that do not point downward.
fn upward(room: &str, source: &str) -> Vec<String> {
    let own = floor(room).unwrap_or_else(|| panic!("room {room} has no floor"));
    uses(source)
        .into_iter()
        .filter(|used| used != room)
        .filter(|used| floor(used).is_some_and(|floor| floor <= own))
        .map(|used| format!("{room} uses {used}"))
        .collect()
}

#[test]
fn arrows_point_downward() {
    let mut faults = Vec::new();
    for path in files("src", "rs") {
        let inner = path.strip_prefix("src").unwrap();
        let room = inner.iter().next().unwrap().to_string_lossy().trim_end_matches(".rs").to_string();
        if room == "lib" {
            continue;
        }
        let source = fs::read_to_string(&path).unwrap();
        faults.extend(upward(&room, &source).into_iter().map(|fault| format!("{}: {fault}", path.display())));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn an_upward_arrow_is_seen() {
    assert_eq!(upward("gpu", "use crate::pipeline::plan;\n"), ["gpu uses pipeline"]);
    assert_eq!(upward("view", "use crate::transport::blocks::push;\n"), ["view uses transport"]);
    assert!(upward("session", "use crate::transport::blocks::push;\nuse crate::pipeline::plan;\n").is_empty());
}

/// Whether a source contains this word, not as the end of a longer one.
fn names(source: &str, word: &str) -> bool {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    source.match_indices(word).any(|(at, _)| !source[..at].ends_with(part))
}

#[test]
fn vulkan_and_unsafe_stay_in_their_room() {
    assert!(names("use ash::vk;", "ash::") && !names("use std::hash::Hash;", "ash::"));
    for path in files("src", "rs").into_iter().filter(|path| !path.starts_with("src/gpu")) {
        let source = fs::read_to_string(&path).unwrap();
        for word in ["ash::", "unsafe "] {
            assert!(!names(&source, word), "{} contains {word}", path.display());
        }
    }
}

#[test]
fn shaders_stand_beside_their_stages() {
    // Outside glsl/measure, glsl/MODULE/NAME.comp or glsl/MODULE/NAME/*.comp belongs to the stage NAME of MODULE, and
    // every stage has at least one shader.
    let mut owners = std::collections::BTreeSet::new();
    for path in files("glsl", "comp").into_iter().filter(|path| !path.starts_with("glsl/measure")) {
        let kernel = path.strip_prefix("glsl").unwrap().with_extension("").to_string_lossy().into_owned();
        let stage =
            milkglass::internals::pipeline::frame::owner(&kernel).unwrap_or_else(|| panic!("{kernel} has no stage"));
        let file = format!("src/{}/{}", stage.module, stage.name);
        assert!(Path::new(&format!("{file}.rs")).exists() || Path::new(&file).is_dir(), "{file}.rs is missing");
        owners.insert(stage.name);
    }
    for stage in milkglass::internals::pipeline::frame::STAGES {
        assert!(owners.contains(stage.name), "stage {} has no shader", stage.name);
    }
}

/// Stage names that are ordinary words in some files: the word, the file, its meaning there.
const ORDINARY: &[(&str, &str, &str)] = &[
    ("irradiance", "src/session/aov.rs", "a layer of an OpenEXR picture"),
    ("environment", "src/view/reflect.rs", "a kernel of another stage"),
    ("irradiance", "src/measure/stress/solve.rs", "a value in the table of cases"),
    ("push", "src/cli/devices.rs", "bytes of push constants"),
    ("push", "src/gpu/choices.rs", "push descriptors and push constants"),
    ("irradiance", "src/cli/view/inspect.rs", "a layer of an OpenEXR picture"),
    ("irradiance", "src/cli/view/turn.rs", "a key of a light"),
];

#[test]
fn stages_are_named_in_their_own_files_only() {
    // Scene files and the layout have their own vocabulary; tests and help texts may name stages.
    let free = |path: &Path| path.starts_with("src/scene") || path.starts_with("src/layout");
    for path in files("src", "rs").into_iter().filter(|path| !free(path)) {
        let source = fs::read_to_string(&path).unwrap();
        let code = source.split("#[cfg(test)]").next().into_iter().flat_map(str::lines);
        let code: Vec<&str> = code.filter(|line| !line.trim_start().starts_with("//")).collect();
        for stage in milkglass::internals::pipeline::frame::STAGES {
            let own = code.iter().any(|line| line.trim() == format!("name: \"{}\",", stage.name));
            let ordinary = ORDINARY.iter().any(|(word, file, _)| *word == stage.name && path.ends_with(file));
            let named = |line: &&&str| !own && !ordinary && line.contains(&format!("\"{}\"", stage.name));
            assert_eq!(code.iter().find(named), None, "{} names stage {}", path.display(), stage.name);
        }
    }
}

#[test]
fn the_guide_lists_every_method() {
    let guide = fs::read_to_string("src/guide/measuring.md").unwrap();
    for method in milkglass::measure::pareto::METHODS {
        assert!(guide.contains(&format!("| `{}` |", method.name)), "the guide's table lacks method {}", method.name);
    }
}

#[test]
fn comments_are_wrapped() {
    for (folder, ending) in [("src", "rs"), ("glsl", "comp"), ("glsl", "glsl"), ("tests", "rs"), ("bench", "rs")] {
        for path in files(folder, ending) {
            let source = fs::read_to_string(&path).unwrap();
            let wide = |line: &&str| line.trim_start().starts_with("//") && line.chars().count() > 120;
            assert_eq!(source.lines().find(wide), None, "{}: a comment beyond column 120", path.display());
        }
    }
}

#[test]
fn device_structs_lie_as_the_host_has_them() {
    let records = milkglass::internals::layout::records();
    let mut seen = std::collections::BTreeSet::new();
    for found in milkglass::internals::gpu::reflect_records().unwrap() {
        let (kernel, name) = (found.kernel, found.name);
        if let Some(record) = records.iter().find(|record| record.name == name) {
            seen.insert(record.name);
            if let Some(stride) = found.stride {
                assert_eq!(stride, record.size, "{kernel}: stride of {name}");
            }
            for member in found.members {
                let field = record.fields.iter().find(|(field, _, _)| *field == member.name);
                assert_eq!(field.map(|f| f.2), Some(member.offset), "{kernel}: {name}.{}", member.name);
            }
        } else if let Some(slot) = milkglass::internals::layout::BUFFER_IDS.iter().find(|slot| slot.spec().name == name)
            && let Some(stride) = found.stride
        {
            assert_eq!(stride, slot.spec().stride, "{kernel}: stride of {name}");
        }
    }
    let missing: Vec<_> = records.iter().map(|r| r.name).filter(|name| !seen.contains(name)).collect();
    assert!(missing.is_empty(), "no kernel shows the layout of {missing:?}");
}

/// The identifiers and numbers of a source, comments excluded.
fn words(source: &str) -> std::collections::BTreeSet<String> {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let code = source.lines().map(|line| line.split("//").next().unwrap_or_default());
    code.flat_map(|line| line.split(|c| !part(c))).filter(|word| !word.is_empty()).map(str::to_string).collect()
}

/// The names that a shader declares as constants.
fn declared(source: &str) -> Vec<String> {
    let code: String = source.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let statements = code.split(';').filter_map(|statement| {
        let (before, constant) = statement.split_once("const ")?;
        (before.trim().is_empty() || before.trim().ends_with(['}', '{', '"', ')'])).then_some(constant.to_string())
    });
    let name =
        |part: &str| part.split_whitespace().last().map(|name| name.split('[').next().unwrap_or(name).to_string());
    statements
        .flat_map(|constant| {
            constant.split(',').map(|part| part.split('=').next().unwrap_or(part).to_string()).collect::<Vec<_>>()
        })
        .filter_map(|part| name(&part))
        .collect()
}

#[test]
fn no_constant_is_written_twice() {
    assert_eq!(
        declared("#include \"a\"\nconst uint A = 1, B[2] = 3;\nfloat C = 4;\nconst float D = 5.0;"),
        ["A", "B", "D"]
    );
    let (numbers, kinds) = (milkglass::internals::layout::numbers(), milkglass::internals::layout::kinds());
    let read = |folder: &str, ending: &str| -> Vec<(PathBuf, String)> {
        files(folder, ending).into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
    };
    let shaders: Vec<_> = [read("glsl", "comp"), read("glsl", "glsl")].concat();
    let mut seen = std::collections::BTreeSet::new();
    let all: Vec<_> = numbers.iter().chain(&kinds).collect();
    for constant in &all {
        assert!(seen.insert(constant.name), "the layout has {} twice", constant.name);
    }

    // No shader redeclares a layout constant, nor writes out a number that can only be one of them.
    for (path, source) in &shaders {
        let again: Vec<_> = declared(source).into_iter().filter(|name| seen.contains(name.as_str())).collect();
        assert!(again.is_empty(), "{} declares {again:?}, as the layout does", path.display());
        let words = words(source);
        for number in ["0xffffffffu", "0xfffffffeu", "65000", "58000", "32768", "4294967295u"] {
            assert!(!words.contains(number), "{} has {number}, a constant of the layout", path.display());
        }
    }

    // Both sides use each number; at least one side uses the values of each kind.
    let host: Vec<_> = read("src", "rs").into_iter().filter(|(path, _)| !path.starts_with("src/layout")).collect();
    let words_of = |sources: &[(PathBuf, String)]| -> std::collections::BTreeSet<String> {
        sources.iter().flat_map(|(_, source)| words(source)).collect()
    };
    let (host, device) = (words_of(&host), words_of(&shaders));
    for constant in &numbers {
        assert!(host.contains(constant.name), "no Rust file uses {}", constant.name);
        assert!(device.contains(constant.name), "no shader uses {}", constant.name);
    }
    for constant in &kinds {
        let prefix = constant.name.split('_').next().unwrap();
        let group = |used: &std::collections::BTreeSet<String>| {
            kinds.iter().any(|kind| kind.name.split('_').next() == Some(prefix) && used.contains(kind.name))
        };
        assert!(group(&host) || group(&device), "nothing uses {}", constant.name);
    }
}
