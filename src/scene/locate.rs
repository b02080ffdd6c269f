//! Locates errors in a scene file: finds the line of a key, rewords messages of serde and TOML, and suggests a
//! correction for a misspelt word.

use super::animate::below;
use crate::error::Input;
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Converts a TOML error in `text` to an input error with file, line and key.
pub(crate) fn from_toml(error: &toml::de::Error, text: &str, file: &Path) -> Input {
    let mut input = in_words(error.message()).file(file);
    if let Some(span) = error.span() {
        input = input.line(line_at(text, span.start));
        if let Some(key) = key_at(text, &span) {
            input = input.key(key);
        }
    }
    input
}

/// Adds the file to an error, and the line of its key or of the nearest parent.
pub(super) fn from_check(input: Input, text: &str, file: &Path) -> Input {
    let line = input.key.as_deref().and_then(|key| line_of(text, key));
    match line {
        Some(line) => input.file(file).line(line),
        None => input.file(file),
    }
}

/// Splits a message of serde or TOML into what, found and expected, and adds a suggestion for a misspelt word.
pub(super) fn in_words(message: &str) -> Input {
    let first = message.lines().next().unwrap_or_default();
    for (start, what) in [("unknown field", "unknown key"), ("unknown variant", "unknown value")] {
        if first.starts_with(start) {
            let words: Vec<&str> = first.split('`').skip(1).step_by(2).collect();
            if let Some((found, accepted)) = words.split_first() {
                let what = with_suggestion(what, found, accepted);
                return Input::new(what).found(found).expected(accepted.join(", "));
            }
        }
    }
    if first.contains("recursion limit") || first.contains("recurse further") {
        return Input::new("lists or tables too deep in one another").expected("at most 80 levels");
    }
    let (fault, expected) = match first.split_once(", expected ") {
        Some((fault, expected)) => (fault, Some(expected)),
        None => (first, None),
    };
    let mut input = match fault.split_once(": ") {
        Some((what @ ("invalid type" | "invalid value"), found)) => Input::new(what).found(found),
        _ => Input::new(fault),
    };
    // A common mistake: [light] for [[light]].
    if input.found.as_deref() == Some("map") && expected == Some("a sequence") {
        input.found = Some("a table".to_owned());
        input.expected = Some("a list of tables: [[light]], [[object]] with double brackets".to_owned());
        return input;
    }
    // Translate the names of Rust types.
    input.expected = expected.map(|expected| match expected {
        "f64" => "a number".to_owned(),
        "i64" => "a whole number".to_owned(),
        "u32" => "a whole number from 0 to 4294967295".to_owned(),
        "a sequence" => "a list".to_owned(),
        words if words.starts_with("struct ") => "a table".to_owned(),
        words => words.to_owned(),
    });
    input
}

/// `what`, with a suggestion if an accepted word is similar to `found`.
pub(super) fn with_suggestion(what: &str, found: &str, accepted: &[&str]) -> String {
    let lower = found.to_lowercase();
    let near = |word: &&str| strsim::jaro_winkler(&lower, &word.to_lowercase());
    let best = accepted.iter().copied().map(|word| (near(&word), word));
    match best.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((nearness, word)) if nearness > 0.75 => format!("{what}, did you mean `{word}`?"),
        _ => what.to_owned(),
    }
}

/// The line, from 1, of a byte offset in the text.
fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|&b| b == b'\n').count()
}

/// The line of a dotted key, or of its nearest parent in the text.
pub(crate) fn line_of(text: &str, key: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let (name, value) = root.get_ref().get_key_value(parts.next()?)?;
    let mut start = name.span().start;
    let mut place = value;
    for part in parts {
        match place.get_ref() {
            DeValue::Table(table) => {
                let Some((name, value)) = table.get_key_value(part) else {
                    break;
                };
                start = name.span().start;
                place = value;
            }
            DeValue::Array(array) => {
                let Some(value) = part.parse().ok().and_then(|n: usize| array.get(n)) else {
                    break;
                };
                start = value.span().start;
                place = value;
            }
            _ => break,
        }
    }
    Some(line_at(text, start))
}

/// The innermost dotted key whose name or value contains the start of a span.
fn key_at(text: &str, span: &Range<usize>) -> Option<String> {
    let root = DeTable::parse(text).ok()?;
    let mut best: Option<(usize, String)> = None;
    walk_table(root.get_ref(), &mut String::new(), &mut |place, key| {
        let size = place.len();
        let holds = place.contains(&span.start) || place == *span;
        if holds && best.as_ref().is_none_or(|(smallest, _)| size <= *smallest) {
            best = Some((size, key.to_owned()));
        }
    });
    best.map(|(_, key)| key)
}

/// Visits every key of a table and of those nested in it, with the spans of its name and its value.
fn walk_table(table: &DeTable<'_>, above: &mut String, visit: &mut dyn FnMut(Range<usize>, &str)) {
    for (name, value) in table {
        below(above, name.get_ref(), |key| {
            visit(name.span(), key);
            visit(value.span(), key);
            walk_value(value.get_ref(), key, visit);
        });
    }
}

fn walk_value(value: &DeValue<'_>, key: &mut String, visit: &mut dyn FnMut(Range<usize>, &str)) {
    match value {
        DeValue::Table(table) => walk_table(table, key, visit),
        DeValue::Array(array) => {
            for (index, element) in array.iter().enumerate() {
                below(key, index, |key| {
                    visit(element.span(), key);
                    walk_value(element.get_ref(), key, visit);
                });
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "unit = 'mm'\n\n[camera]\nfov = 30\n\n[[light]]\n[[light]]\ntype = 'point'\n";

    #[test]
    fn finds_the_line_of_a_key_or_its_parent() {
        assert_eq!(line_of(TEXT, "unit"), Some(1));
        assert_eq!(line_of(TEXT, "camera.fov"), Some(4));
        assert_eq!(line_of(TEXT, "camera.size"), Some(3));
        assert_eq!(line_of(TEXT, "light.1.type"), Some(8));
        assert_eq!(line_of(TEXT, "light.1.position"), Some(7));
        assert_eq!(line_of(TEXT, "object"), None);
    }

    #[test]
    fn finds_the_key_of_a_span() {
        let byte = TEXT.find("30").unwrap_or_default();
        assert_eq!(key_at(TEXT, &(byte..byte + 2)).as_deref(), Some("camera.fov"));
        let byte = TEXT.find("'point'").unwrap_or_default();
        assert_eq!(key_at(TEXT, &(byte..byte + 7)).as_deref(), Some("light.1.type"));
    }

    #[test]
    fn puts_messages_into_words() {
        let cases = [
            (
                "unknown field `fow`, expected one of `fov`, `up`",
                "unknown key, did you mean `fov`?; found fow; expected fov, up",
            ),
            ("unknown field `x`, expected `a` or `b`", "unknown key; found x; expected a, b"),
            ("invalid type: string \"a\", expected f64", "invalid type; found string \"a\"; expected a number"),
            ("missing field `type`", "missing field `type`"),
            ("key with no value, expected `=`", "key with no value; expected `=`"),
        ];
        for (message, words) in cases {
            assert_eq!(in_words(message).to_string(), words);
        }
    }
}
