//! Keyframes: any number or list of numbers in a scene file may be a table `{ keyframes = [[frame, value], ...] }`, and
//! a mesh may be one file per frame: `mesh = "walk-%04d.obj"`.

use super::range::Checked;
use crate::error::Input;
use std::fmt::Write as _;
use toml::{Table, Value};

/// Interpolation between two keyframes: linear, or with a soft start and end.
#[derive(Clone, Copy)]
enum Curve {
    Linear,
    Smooth,
}

/// The table with every value evaluated at a frame, and whether any of them is animated.
pub(super) fn at(table: &Table, frame: f64) -> Checked<(Table, bool)> {
    let mut moves = false;
    let mut still = Table::new();
    for (name, value) in table {
        still.insert(name.clone(), value_at(value, &mut name.clone(), frame, &mut moves)?);
    }
    Ok((still, moves))
}

/// The first and the last frame of all keyframes of a value that was read; none without keyframes.
pub(super) fn frames(value: &Value) -> Option<[f64; 2]> {
    let all = |values: &mut dyn Iterator<Item = &Value>| values.map(frames).reduce(both).flatten();
    match value {
        Value::Table(table) => match table.get("keyframes").and_then(Value::as_array) {
            Some(list) => {
                let at = |pair: Option<&Value>| number(pair?.as_array()?.first()?);
                Some([at(list.first())?, at(list.last())?])
            }
            None => all(&mut table.values()),
        },
        Value::Array(list) => all(&mut list.iter()),
        _ => None,
    }
}

/// The smallest range that contains both.
pub(super) fn both(one: Option<[f64; 2]>, other: Option<[f64; 2]>) -> Option<[f64; 2]> {
    let (Some(a), Some(b)) = (one, other) else { return one.or(other) };
    Some([a[0].min(b[0]), a[1].max(b[1])])
}

/// A value at a frame. `key` is extended and truncated in place, since names and lists may be long.
fn value_at(value: &Value, key: &mut String, frame: f64, moves: &mut bool) -> Checked<Value> {
    match value {
        Value::Table(table) if table.contains_key("keyframes") => {
            *moves = true;
            keyed(table, key, frame)
        }
        Value::Table(table) => {
            let inner = |(name, value): (&String, &Value)| {
                Ok((name.clone(), below(key, name, |key| value_at(value, key, frame, moves))?))
            };
            Ok(Value::Table(table.iter().map(inner).collect::<Checked<_>>()?))
        }
        Value::Array(list) => {
            let inner = |(number, value)| below(key, number, |key| value_at(value, key, frame, moves));
            Ok(Value::Array(list.iter().enumerate().map(inner).collect::<Checked<_>>()?))
        }
        Value::String(path) if key.starts_with("object.") && key.ends_with(".mesh") => {
            // Round to the nearest frame.
            let file = numbered(path, frame.round() as i64);
            *moves |= file.is_some();
            Ok(Value::String(file.unwrap_or_else(|| path.replace("%%", "%"))))
        }
        plain => Ok(plain.clone()),
    }
}

/// Calls `go` with the key extended by a part.
pub(super) fn below<R>(key: &mut String, part: impl std::fmt::Display, go: impl FnOnce(&mut String) -> R) -> R {
    let length = key.len();
    // Writing to a string does not fail.
    let _ = if key.is_empty() { write!(key, "{part}") } else { write!(key, ".{part}") };
    let made = go(key);
    key.truncate(length);
    made
}

/// A file name with its one `%d` or `%04d` replaced by a frame's number, and `%%` by `%`; `None` unless it has exactly
/// one such placeholder.
#[must_use]
pub fn numbered(text: &str, frame: i64) -> Option<String> {
    let (mut name, mut rest, mut found) = (String::new(), text, false);
    while let Some((before, after)) = rest.split_once('%') {
        name.push_str(before);
        if let Some(after) = after.strip_prefix('%') {
            name.push('%');
            rest = after;
            continue;
        }
        let (digits, after) = after.split_once('d')?;
        if found || !(digits.is_empty() || digits.starts_with('0')) {
            return None;
        }
        let width = if digits.is_empty() { 0 } else { digits.parse::<usize>().ok().filter(|width| *width <= 20)? };
        // Writing to a string does not fail.
        let _ = write!(name, "{frame:0width$}");
        (rest, found) = (after, true);
    }
    name.push_str(rest);
    found.then_some(name)
}

/// The value that keyframes give at a frame: before the first keyframe that one's, after the last keyframe that one's.
fn keyed(table: &Table, key: &str, frame: f64) -> Checked<Value> {
    let fault =
        |what: &str, found: String, expected: &str| Err(Input::new(what).key(key).found(found).expected(expected));
    if let Some(other) = table.keys().find(|name| !["keyframes", "curve"].contains(&name.as_str())) {
        return fault("unknown key", other.clone(), "keyframes, curve");
    }
    let curve = match table.get("curve").map(|curve| (curve, curve.as_str())) {
        None | Some((_, Some("linear"))) => Curve::Linear,
        Some((_, Some("smooth"))) => Curve::Smooth,
        Some((other, _)) => return fault("unknown curve", other.to_string(), "\"linear\" or \"smooth\""),
    };
    let shape = "[[frame, value], ...], frames ascending, values all numbers or all lists of the same length";
    let Some(list) = table.get("keyframes").and_then(Value::as_array).filter(|list| !list.is_empty()) else {
        return fault("not a list of keyframes", table["keyframes"].to_string(), shape);
    };
    let mut keys: Vec<(f64, &Value)> = Vec::new();
    for pair in list {
        let both = pair.as_array().filter(|pair| pair.len() == 2);
        let Some((at, value)) = both.and_then(|pair| Some((number(&pair[0])?, &pair[1]))) else {
            return fault("not a keyframe", pair.to_string(), shape);
        };
        if keys.last().is_some_and(|(before, _)| *before >= at) {
            return fault("keyframes are not in order", at.to_string(), shape);
        }
        if !finite(value) {
            return fault("a keyframe's value is not finite", pair.to_string(), shape);
        }
        keys.push((at, value));
    }
    let after = keys.partition_point(|(at, _)| *at <= frame);
    let ((from, a), (to, b)) = (keys[after.saturating_sub(1)], keys[after.min(keys.len() - 1)]);
    let t = if to > from { ((frame - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    let t = match curve {
        Curve::Linear => t,
        Curve::Smooth => t * t * (3.0 - 2.0 * t),
    };
    let mixed = keys.iter().all(|(_, value)| mix(a, value, 0.0).is_some()).then(|| mix(a, b, t)).flatten();
    mixed.map_or_else(|| fault("keyframes of different kinds", table["keyframes"].to_string(), shape), Ok)
}

/// Whether all numbers in the value are finite.
fn finite(value: &Value) -> bool {
    match value {
        Value::Array(list) => list.iter().all(finite),
        Value::Float(number) => number.is_finite(),
        _ => true,
    }
}

/// A finite number.
fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
    number.filter(|x| x.is_finite())
}

/// Interpolates between two values of one kind; integers stay integers if the result is whole.
fn mix(a: &Value, b: &Value, t: f64) -> Option<Value> {
    match (a, b) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            Some(Value::Array(a.iter().zip(b).map(|(a, b)| mix(a, b, t)).collect::<Option<_>>()?))
        }
        _ => {
            let (from, to) = (number(a)?, number(b)?);
            let value = from + t * (to - from);
            let whole = a.is_integer() && b.is_integer() && value.fract() == 0.0;
            Some(if whole { Value::Integer(value as i64) } else { Value::Float(value) })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, frame: f64) -> Checked<Value> {
        let table: Table = toml::from_str(&format!("x = {{ y = [{text}] }}")).unwrap();
        at(&table, frame).map(|(still, _)| still["x"]["y"][0].clone())
    }

    #[test]
    fn between_keyframes() {
        let line = "{ keyframes = [[0, 1], [10, 3.0], [20, 3]] }";
        let cases = [(-5.0, 1.0), (0.0, 1.0), (5.0, 2.0), (10.0, 3.0), (15.0, 3.0), (99.0, 3.0)];
        for (frame, expected) in cases {
            assert_eq!(number(&value(line, frame).unwrap()), Some(expected), "{frame}");
        }
        let soft = "{ curve = 'smooth', keyframes = [[0, 0], [4, [1]]] }";
        assert!(value(soft, 1.0).is_err());
        let soft = "{ curve = 'smooth', keyframes = [[0, [0]], [4, [1]]] }";
        assert_eq!(value(soft, 1.0).unwrap()[0].as_float(), Some(0.15625));
        assert_eq!(value("{ keyframes = [[0, 2], [2, 6]] }", 1.0).unwrap(), Value::Integer(4));
        assert_eq!(value("{ keyframes = [[3, 2]] }", 1.0).unwrap(), Value::Integer(2));
        let still: Table = toml::from_str("a = 1").unwrap();
        assert_eq!(at(&still, 3.0).unwrap(), (still, false));
    }

    #[test]
    fn the_range_of_frames_is_that_of_all_keyframes() {
        let text = "a = { b = [{ keyframes = [[3, 0], [9.5, 1]] }, 1] }\nc = { keyframes = [[-2, 0], [4, 1]] }";
        let range = |text: &str| frames(&Value::Table(toml::from_str(text).unwrap()));
        assert_eq!(range(text), Some([-2.0, 9.5]));
        assert_eq!(range("a = [1, 2]"), None);
        let scene = crate::Scene::load("twist").unwrap();
        assert_eq!((scene.frames, crate::Scene::load("slab").unwrap().frames), (Some([0.0, 59.0]), None));
    }

    #[test]
    fn numbers_have_their_place() {
        let name = |text: &str, frame| numbered(text, frame);
        assert_eq!(name("a/f%04d.png", 7).as_deref(), Some("a/f0007.png"));
        assert_eq!(name("%d.exr", -12).as_deref(), Some("-12.exr"));
        assert_eq!(name("100%%d/%d.exr", 3).as_deref(), Some("100%d/3.exr"));
        for bad in ["a.png", "%04x.png", "%d%d.png", "%4d.png", "%099d.png", "100%.png", "100%%d.png"] {
            assert_eq!(name(bad, 1), None, "{bad}");
        }
    }

    #[test]
    fn faults_name_the_key() {
        for (text, what) in [
            ("{ keyframes = [] }", "not a list of keyframes"),
            ("{ keyframes = 3 }", "not a list of keyframes"),
            ("{ keyframes = [[0, 1], [1]] }", "not a keyframe"),
            ("{ keyframes = [[0, 1], ['a', 2]] }", "not a keyframe"),
            ("{ keyframes = [[0, 1], [nan, 2]] }", "not a keyframe"),
            ("{ keyframes = [[2, 1], [1, 2]] }", "not in order"),
            ("{ keyframes = [[0, 1], [1, nan]] }", "not finite"),
            ("{ keyframes = [[0, [1, 2]], [1, [1, inf]]] }", "not finite"),
            ("{ keyframes = [[0, 1], [1, [1, 2]]] }", "different kinds"),
            ("{ keyframes = [[0, 'a'], [1, 'b']] }", "different kinds"),
            ("{ keyframes = [[0, 1]], curve = 'round' }", "unknown curve"),
            ("{ keyframes = [[0, 1]], curves = 'linear' }", "unknown key"),
        ] {
            let fault = value(text, 0.5).unwrap_err().to_string();
            assert!(fault.starts_with("x.y.0: ") && fault.contains(what), "{text}: {fault}");
        }
    }
}
