//! `--set key=value`: changes to a scene's table before it is checked.

use super::range::Checked;
use crate::error::Input;
use toml::{Table, Value};

/// Maximum number of names in a key: no scene nests as deeply, and nested tables are visited recursively.
const MOST_PARTS: usize = 16;

/// Applies one `key=value` to the table. The key is dotted, numbers index lists; missing tables are created, and an
/// index one past the end of a list appends. The value is TOML, or else plain text.
pub(super) fn apply(table: &mut Table, set: &str) -> Checked<()> {
    let fault = |what: String| Input::new(what).key(format!("--set {set}"));
    let (key, value) = set
        .split_once('=')
        .ok_or_else(|| fault("not a setting".to_owned()).expected("key=value, such as object.0.size=30"))?;
    let parts: Vec<&str> = key.split('.').map(str::trim).collect();
    if parts.iter().any(|part| part.is_empty()) {
        let fault = fault("an empty name in the key".to_owned()).found(format!("`{}`", key.trim()));
        return Err(fault.expected("names and numbers joined by single dots"));
    }
    if parts.len() > MOST_PARTS {
        let fault = fault("a key of too many names".to_owned()).found(parts.len());
        return Err(fault.expected(format!("at most {MOST_PARTS}")));
    }

    // Descend to the value, creating what is missing.
    let mut rest = parts.iter().copied().enumerate().peekable();
    let mut place: Option<&mut Value> = None;
    while let Some((depth, part)) = rest.next() {
        let list = rest.peek().is_some_and(|(_, next)| next.parse::<usize>().is_ok());
        place = Some(match place {
            None => table.entry(part).or_insert_with(|| empty(list)),
            Some(above) => slot(above, part, &parts[..depth].join("."), list)
                .map_err(|(what, expected)| fault(what).expected(expected))?,
        });
    }
    if let Some(place) = place {
        *place = parse(value.trim());
    }
    if let [.., "material", "preset"] = parts[..] {
        forget_coefficients(table, &parts[..parts.len() - 1]);
    }
    Ok(())
}

/// Setting a preset replaces the coefficients of the file, which would override it.
fn forget_coefficients(table: &mut Table, path: &[&str]) {
    let Some((first, rest)) = path.split_first() else { return };
    let mut place = table.get_mut(*first);
    for part in rest {
        place = match place {
            Some(Value::Table(table)) => table.get_mut(*part),
            Some(Value::Array(list)) => part.parse::<usize>().ok().and_then(|index| list.get_mut(index)),
            _ => None,
        };
    }
    if let Some(Value::Table(material)) = place {
        for key in ["sigma_s_prime", "sigma_a", "eta"] {
            material.remove(key);
        }
    }
}

/// The value under one part of a key, created if missing; the error has what is wrong and what is expected.
fn slot<'a>(place: &'a mut Value, part: &str, path: &str, list: bool) -> Result<&'a mut Value, (String, String)> {
    match place {
        Value::Table(table) => Ok(table.entry(part).or_insert_with(|| empty(list))),
        Value::Array(array) => {
            let count = array.len();
            let wrong = || {
                let what = format!("`{path}` is a list of {count}; it has no `{part}`");
                (what, format!("a number from 0 to {count}, the last of which appends"))
            };
            let index: usize = part.parse().map_err(|_| wrong())?;
            if index == count {
                array.push(empty(list));
            }
            array.get_mut(index).ok_or_else(wrong)
        }
        other => {
            let what = format!("`{path}` is not a table; it has no `{part}`");
            Err((what, format!("`{path}` itself, of type {}", other.type_str())))
        }
    }
}

/// The value created for a missing part of a key.
fn empty(list: bool) -> Value {
    if list { Value::Array(Vec::new()) } else { Value::Table(Table::new()) }
}

/// A TOML value, or the text itself.
fn parse(text: &str) -> Value {
    text.parse().unwrap_or_else(|_| Value::String(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use crate::scene::overrides::*;

    #[test]
    fn sets_numbers_text_lists_and_tables() {
        let cases = [
            ("", "unit=cm", "{ unit = \"cm\" }"),
            ("", "a.b.c = 1.5", "{ a = { b = { c = 1.5 } } }"),
            ("a = 1", "a='x=y'", "{ a = \"x=y\" }"),
            ("a = 1", "a=x=y", "{ a = \"x=y\" }"),
            ("a = [1, 2]", "a.1=5", "{ a = [1, 5] }"),
            ("a = [1, 2]", "a.2=5", "{ a = [1, 2, 5] }"),
            ("", "object.0.size=3", "{ object = [{ size = 3 }] }"),
            ("[[light]]\nx = 1", "light.0.x=[1, 2]", "{ light = [{ x = [1, 2] }] }"),
            ("[[light]]\nx = 1", "light.1.y=true", "{ light = [{ x = 1 }, { y = true }] }"),
            ("", "a=1\nb=2", "{ a = \"1\\nb=2\" }"),
        ];
        for (text, set, expected) in cases {
            let expected: Table = toml::from_str(&format!("v = {expected}")).expect(expected);
            let mut table: Table = toml::from_str(text).expect(text);
            let result = apply(&mut table, set).map_err(|e| e.to_string());
            assert_eq!((result, Some(&Value::Table(table))), (Ok(()), expected.get("v")), "{set}");
        }
    }

    #[test]
    fn names_the_setting_at_fault() {
        let cases = [
            ("size", "--set size: not a setting; expected key=value"),
            ("=3", "--set =3: an empty name in the key; found ``"),
            ("a..b=3", "--set a..b=3: an empty name in the key; found `a..b`"),
            ("n.x=3", "--set n.x=3: `n` is not a table; it has no `x`; expected `n` itself, of type integer"),
            ("l.2=3", "--set l.2=3: `l` is a list of 1; it has no `2`; expected a number from 0 to 1"),
            ("l.x=3", "--set l.x=3: `l` is a list of 1; it has no `x`"),
        ];
        for (set, message) in cases {
            let mut table: Table = toml::from_str("n = 1\nl = [7]").expect("a table");
            let error = apply(&mut table, set).map_err(|e| e.to_string()).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
