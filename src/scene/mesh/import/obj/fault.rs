//! The first faulty `v` or `f` statement of a Wavefront OBJ file, for the error message.

use super::{LARGEST, index_of, statements};
use crate::error::Input;

/// The first fault, with its line. `vertices` is the number of `v` statements in the whole file.
pub(super) fn first(text: &str, vertices: usize) -> Option<Input> {
    let mut before = 0;
    statements(text).find_map(|(line, statement)| {
        let mut words = statement.split_whitespace();
        let name = words.next()?;
        let words: Vec<&str> = words.collect();
        let fault = match name {
            "v" => {
                before += 1;
                in_vertex(&words)
            }
            "f" => in_face(&words, before, vertices),
            _ => None,
        };
        fault.map(|fault| fault.line(line))
    })
}

/// The fault of a `v` statement.
fn in_vertex(words: &[&str]) -> Option<Input> {
    let expected = "three numbers of at most 1e30";
    if words.len() < 3 {
        let fault = Input::new("a vertex has too few coordinates");
        return Some(fault.found(words.len()).expected(expected));
    }
    let weight = if words.len() == 4 { words.get(3) } else { None };
    let mut values = Vec::with_capacity(4);
    for word in words.iter().take(3).chain(weight) {
        match word.parse::<f64>() {
            Ok(value) => values.push(value),
            Err(_) => {
                let fault = Input::new("a coordinate is not a number");
                return Some(fault.found(format!("`{word}`")).expected(expected));
            }
        }
    }
    let weight = values.get(3).copied().unwrap_or(1.0);
    let not_finite = |value: &&f64| !(**value / weight).is_finite();
    if let Some(value) = values.iter().take(3).find(not_finite) {
        let found = if weight == 0.0 { "a weight of 0".to_owned() } else { value.to_string() };
        return Some(Input::new("a coordinate is not finite").found(found).expected(expected));
    }
    let value = values.iter().take(3).find(|value| (**value / weight).abs() > LARGEST)?;
    let fault = Input::new("a coordinate is too large");
    Some(fault.found(format!("{value:e}")).expected(expected))
}

/// The fault of an `f` statement that follows `before` of the `vertices` vertices of the file.
fn in_face(words: &[&str], before: usize, vertices: usize) -> Option<Input> {
    for word in words {
        let Ok(index) = index_of(word).parse::<i64>() else {
            let fault = Input::new("a corner of a face is not a vertex number");
            return Some(fault.found(format!("`{word}`")).expected("such as 7, 7/2, 7//3 or 7/2/3"));
        };
        // Negative numbers count back from the last vertex so far.
        let limit = if index < 0 { before } else { vertices };
        let place = usize::try_from(index.unsigned_abs()).unwrap_or(usize::MAX);
        if place == 0 || place > limit {
            let expected = match (vertices, before) {
                (0, _) => "vertices before faces".to_owned(),
                (_, 0) => format!("1 to {vertices}"),
                _ => format!("1 to {vertices}, or -{before} to -1"),
            };
            let fault = Input::new("a face names a vertex that is not there");
            return Some(fault.found(index).expected(expected));
        }
    }
    if words.len() < 3 {
        let fault = Input::new("a face has too few corners");
        return Some(fault.found(words.len()).expected("three or more"));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    #[test]
    fn every_fault_has_a_line_and_a_reason() {
        let start = "# three\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let cases = [
            ("f 1 2 0", "a face names a vertex that is not there; found 0; expected 1 to 3, or -3 to -1"),
            ("f 1 2 4", "a face names a vertex that is not there; found 4"),
            ("f 1 2 -4", "a face names a vertex that is not there; found -4"),
            ("f 1 2 99999999999999999999", "a corner of a face is not a vertex number; found `99999"),
            ("f 1 2 9223372036854775807", "a face names a vertex that is not there; found 922"),
            ("f 1 2 x/1", "a corner of a face is not a vertex number; found `x/1`; expected such as 7"),
            ("f 1 2 /1", "a corner of a face is not a vertex number; found `/1`"),
            ("f 1 2", "a face has too few corners; found 2; expected three or more"),
            ("f", "a face has too few corners; found 0"),
            ("v 1 2", "a vertex has too few coordinates; found 2; expected three numbers"),
            ("v 1 2 abc", "a coordinate is not a number; found `abc`"),
            ("v 1 nan 3\nf 1 2 4", "a coordinate is not finite; found NaN"),
            ("v 1 2 1e999\nf 1 2 4", "a coordinate is not finite; found inf"),
            ("v 1 2 1e40\nf 1 2 4", "a coordinate is too large; found 1e40"),
            ("v 1 2 3 0\nf 1 2 4", "a coordinate is not finite; found a weight of 0"),
        ];
        for (statement, expected) in cases {
            let text = format!("{start}{statement}\nf 1 2 3\n");
            let error = parse(&text, false).err().map(|e| (e.line, e.to_string())).unwrap_or_default();
            assert!(error.0 == Some(5) && error.1.starts_with(expected), "{error:?}");
        }
    }

    #[test]
    fn a_coordinate_at_fault_is_found_before_the_face_that_uses_it() {
        let text = "v 0 0 0\nv 1 0 0\nf 1 2 3\n\nv 0 inf 0\n";
        let error = parse(text, false).err().map(|e| (e.line, e.to_string())).unwrap_or_default();
        assert_eq!(error.0, Some(5), "{error:?}");
    }
}
