//! Every value has one type: no two structs have the same fields, and no two enums the same variants.

use std::collections::BTreeMap;
use std::fs;

use super::files;

/// Pairs that mean different things although their parts have the same names, and why each is two.
const DIFFERENT: &[([&str; 2], &str)] = &[
    (["Binding", "BoundRange"], "what a stage binds, by buffer; what a list has bound, by the driver's handle"),
    (["Bound", "Worst"], "what an error may be, as a case declares it, and what it was"),
    (
        ["Fresnel", "Integration"],
        "formulas for the boundary, and ways to sum along a ray; both are as in a paper or exact",
    ),
    (
        ["LightKind", "Source"],
        "the type of a light as the scene file names it, and a light of that type with its values",
    ),
    (["Known", "Pending"], "counts of batches on two queues, and places in one list"),
    (["LayerFile", "SlabLayer"], "a layer as the scene file has it, and one as the formula takes it"),
    (
        ["Distance", "Distance"],
        "as a scene file chooses it, and as a form factor takes it: with clamped sources, or not",
    ),
    (["Reflection", "ReflectionKind"], "a reflection with its values, and its name in the scene file"),
];

/// The structs or enums of a source: their names, with those of their fields or variants.
fn types(source: &str, word: &str) -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    let mut lines = source.lines();
    while let Some(line) = lines.next() {
        let Some(head) = line.split(&format!("{word} ")).nth(1).filter(|_| line.ends_with('{')) else { continue };
        if !line.trim_start().starts_with("pub") && !line.starts_with(word) {
            continue;
        }
        let indent = line.len() - line.trim_start().len();
        let name: String = head.chars().take_while(|c| c.is_alphanumeric()).collect();
        let inside = lines.by_ref().take_while(|line| line.trim() != "}" || line.len() > indent + 1);
        let part = |line: &str| {
            let own = line.len() - line.trim_start().len() == indent + 4;
            let text = line.trim().trim_start_matches("pub(super) ").trim_start_matches("pub(crate) ");
            let text = text.trim_start_matches("pub ");
            let name: String = text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let after = text[name.len()..].chars().next();
            let named = if word == "struct" { after == Some(':') } else { matches!(after, Some(',' | '(' | ' ')) };
            (own && named && !text.starts_with("//") && !text.starts_with('#')).then_some(name)
        };
        let mut parts: Vec<String> = inside.filter_map(part).filter(|name| !name.is_empty()).collect();
        parts.sort();
        found.push((name, parts));
    }
    found
}

/// The groups of types with the same parts, at least two of them.
fn twins(sources: &[String], word: &str) -> Vec<Vec<String>> {
    let mut by_parts: BTreeMap<Vec<String>, Vec<String>> = BTreeMap::new();
    for (name, parts) in sources.iter().flat_map(|source| types(source, word)) {
        if parts.len() > 1 {
            by_parts.entry(parts).or_default().push(name);
        }
    }
    by_parts.into_values().filter(|names| names.len() > 1).collect()
}

#[test]
fn every_value_has_one_type() {
    let read = |path: &std::path::PathBuf| fs::read_to_string(path).unwrap();
    let sources: Vec<String> = files("src", "rs").iter().map(read).collect();
    let found = sources.iter().map(|source| types(source, "struct").len()).sum::<usize>();
    assert!(found > 300, "only {found} structs were found");
    let mut all: Vec<Vec<String>> = ["struct", "enum"].iter().flat_map(|word| twins(&sources, word)).collect();
    all.iter_mut().for_each(|names| names.sort());
    let new: Vec<_> = all.iter().filter(|names| DIFFERENT.iter().all(|(pair, _)| *names != pair)).collect();
    assert!(new.is_empty(), "{new:?} have the same parts: make one type of each, or say in DIFFERENT why they are two");
    for (pair, _) in DIFFERENT {
        assert!(all.iter().any(|names| names == pair), "{pair:?} are no twins any more: take them off the list");
    }
}

#[test]
fn twins_are_found() {
    let one = "pub struct One {\n    /// A.\n    pub a: f32,\n    b: Vec<u32>,\n}\n".to_string();
    let two =
        "struct Two<'a> {\n    b: &'a str,\n    pub(super) a: u8,\n}\nstruct Three {\n    a: u8,\n}\n".to_string();
    assert_eq!(twins(&[one, two], "struct"), [["One", "Two"]]);
    let three = "enum Three {\n    #[default]\n    A,\n    B(u32),\n}\npub enum Four {\n    B { x: u32 },\n    A,\n}\n";
    assert_eq!(twins(&[three.to_string()], "enum"), [["Three", "Four"]]);
}
