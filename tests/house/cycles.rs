//! No cycles of three or more files within a module, judging by their `use` lines.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::Path;

use super::files;

/// Modules that still have such cycles.
const CYCLIC: &[&str] = &["layers", "scene"];

/// A module path: `gpu::count::read`; empty for the library itself.
type Module = Vec<String>;

/// Source text by module path.
struct Sources(BTreeMap<Module, String>);

impl Sources {
    /// All files below `src` except main.rs.
    fn read() -> Self {
        let module = |path: &Path| {
            let inner = path.strip_prefix("src").unwrap().with_extension("");
            let names = inner.iter().map(|name| name.to_string_lossy().into_owned());
            names.filter(|name| name != "mod" && name != "lib").collect()
        };
        let paths = files("src", "rs").into_iter().filter(|path| !path.ends_with("main.rs"));
        Self(paths.map(|path| (module(&path), fs::read_to_string(&path).unwrap())).collect())
    }

    /// The module that a path leads to, seen from the module that uses it. A re-exported name leads to the file that
    /// defines it. `None` for other crates.
    fn target(&self, from: &Module, path: &[String]) -> Option<Module> {
        let mut rest = path;
        let mut at = match rest.first()?.as_str() {
            "crate" => Module::new(),
            "super" | "self" => from.clone(),
            child if self.0.contains_key(&[from, &[child.to_string()][..]].concat()) => from.clone(),
            _ => return None,
        };
        while let Some((step, after)) = rest.split_first() {
            let child = [&at[..], std::slice::from_ref(step)].concat();
            match step.as_str() {
                "crate" | "self" => {}
                "super" => drop(at.pop()),
                _ if self.0.contains_key(&child) => at = child,
                _ => {
                    // A name that this module defines or re-exports.
                    let exported = paths(self.0.get(&at)?, true).into_iter().find(|path| path.last() == Some(step));
                    return exported.and_then(|path| self.target(&at, &path)).or(Some(at));
                }
            }
            rest = after;
        }
        Some(at)
    }

    /// For each file of a module, the other files of that module that it uses.
    fn uses(&self, room: &str) -> BTreeMap<Module, BTreeSet<Module>> {
        let inside = |module: &Module| module.first().is_some_and(|first| first == room);
        let used = |(module, source): (&Module, &String)| {
            let targets = paths(source, false).into_iter().filter_map(|path| self.target(module, &path));
            (module.clone(), targets.filter(|target| inside(target) && target != module).collect())
        };
        self.0.iter().filter(|(module, _)| inside(module)).map(used).collect()
    }
}

/// The paths in a source's `use` lines, braces expanded: those that it re-exports, or the others.
fn paths(source: &str, exported: bool) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    // Uses by tests do not count.
    let code = source.split("#[cfg(test)]\nmod ").next().unwrap();
    let mut lines = code.lines().map(str::trim);
    while let Some(line) = lines.next() {
        let Some((visibility, tree)) = line.split_once("use ") else { continue };
        if !["", "pub ", "pub(super) ", "pub(crate) "].contains(&visibility) {
            continue;
        }
        let mut tree = tree.to_string();
        while !tree.ends_with(';') {
            tree += lines.next().unwrap();
        }
        if visibility.is_empty() != exported {
            expand(&[], tree.trim_end_matches(';'), &mut found);
        }
    }
    found
}

/// Expands `a::{b, c::d as e}` to `a::b` and `a::c::d`.
fn expand(prefix: &[String], tree: &str, out: &mut Vec<Vec<String>>) {
    let (head, group) = match tree.split_once('{') {
        Some((head, group)) => (head, group.strip_suffix('}')),
        None => (tree, None),
    };
    let head = head.split(" as ").next().unwrap();
    let names = head.split("::").map(str::trim).filter(|name| !name.is_empty() && *name != "*");
    let path: Vec<String> = prefix.iter().cloned().chain(names.map(String::from)).collect();
    let Some(group) = group else { return out.push(path) };
    let (mut depth, mut start) = (0, 0);
    for (at, c) in group.char_indices().chain([(group.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !group[start..at].trim().is_empty() {
                    expand(&path, group[start..at].trim(), out);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

/// The shortest cycle of more than two files, as `a -> b -> c -> a`.
fn cycle(uses: &BTreeMap<Module, BTreeSet<Module>>) -> Option<String> {
    let mut best: Option<Vec<&Module>> = None;
    for (first, seconds) in uses {
        for second in seconds {
            // The shortest way back, except the direct one.
            let mut before = BTreeMap::from([(second, second)]);
            let mut queue = VecDeque::from([second]);
            while let Some(at) = queue.pop_front() {
                for next in uses.get(at).into_iter().flatten() {
                    if (at, next) != (second, first) && !before.contains_key(next) {
                        before.insert(next, at);
                        queue.push_back(next);
                    }
                }
            }
            if before.contains_key(first) {
                let mut way = vec![first];
                while way.last() != Some(&second) {
                    way.push(before[way[way.len() - 1]]);
                }
                way.push(first);
                way.reverse();
                if best.as_ref().is_none_or(|best| way.len() < best.len()) {
                    best = Some(way);
                }
            }
        }
    }
    best.map(|way| way.iter().map(|module| module.join("::")).collect::<Vec<_>>().join(" -> "))
}

#[test]
fn files_of_a_room_use_each_other_in_no_cycle() {
    let sources = Sources::read();
    let rooms: BTreeSet<&String> = sources.0.keys().filter_map(|module| module.first()).collect();
    assert!(sources.uses("gpu").values().map(BTreeSet::len).sum::<usize>() > 20, "too few uses were found in gpu");
    let cycles = rooms.into_iter().filter(|room| !CYCLIC.contains(&room.as_str()));
    let cycles: Vec<String> = cycles.filter_map(|room| cycle(&sources.uses(room))).collect();
    assert!(
        cycles.is_empty(),
        "these files use each other in a cycle (`A -> B` where A uses B):\n{}",
        cycles.join("\n")
    );
}

/// A cycle is found through braces, re-exports and folders; two files that use each other are no cycle.
#[test]
fn a_planted_cycle_is_seen() {
    let seen = |files: &[(&str, &str)]| {
        let module = |name: &str| name.split("::").map(String::from).collect();
        let list = files.iter().map(|(name, source)| (module(name), source.to_string()));
        cycle(&Sources(list.collect()).uses("a"))
    };
    let root = ("a", "mod x;\nmod y;\nmod z;\npub use z::Last;\n");
    let x = ("a::x", "use std::rc::Rc;\n\nuse super::{\n    Last,\n    y::{self, Other as Renamed},\n};\nfn f() {}\n");
    let y = (
        "a::y",
        "// use super::x::Commented;\nuse super::x::First;\n#[cfg(test)]\nmod tests {\n    use super::z;\n}\n",
    );
    assert_eq!(seen(&[root, x, y, ("a::z", "pub struct Last;\n")]), None);
    let z = ("a::z", "use crate::a::y::Other;\npub struct Last;\n");
    assert_eq!(seen(&[root, x, y, z]).unwrap(), "a::x -> a::z -> a::y -> a::x");
    let inner = [("a::x", "mod deep;\nuse deep::D;\n"), ("a::x::deep", "use super::super::z::Last;\n")];
    let back = ("a::z", "use super::x;\npub struct Last;\n");
    assert_eq!(seen(&[root, inner[0], inner[1], back]).unwrap(), "a::x -> a::x::deep -> a::z -> a::x");
}
