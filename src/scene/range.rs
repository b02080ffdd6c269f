//! Checks of single values: finite and within range, or an error that names the key.

use crate::error::Input;
use glam::DVec3;

/// The result of a check; file and line are added to the error later.
pub(super) type Checked<T> = Result<T, Input>;

/// The largest absolute coordinate in a scene file, in scene units.
pub(super) const LARGEST: f64 = 1e9;

/// A finite number for which `accept` holds; `expected` describes the range in the error.
pub(super) fn number(key: &str, value: f64, accept: impl Fn(f64) -> bool, expected: &str) -> Checked<f64> {
    if value.is_finite() && accept(value) {
        return Ok(value);
    }
    let what = if value.is_finite() { "out of range" } else { "not a finite number" };
    Err(Input::new(what).key(key).found(value).expected(expected))
}

/// Three finite channels, for each of which `accept` holds.
pub(super) fn channels(key: &str, values: [f64; 3], accept: impl Fn(f64) -> bool, expected: &str) -> Checked<[f64; 3]> {
    match fault_in(values, &accept) {
        None => Ok(values),
        Some(what) => Err(Input::new(what).key(key).found(list(&values)).expected(expected)),
    }
}

/// A point: three finite coordinates of at most [`LARGEST`].
pub(super) fn point(key: &str, values: [f64; 3]) -> Checked<DVec3> {
    let expected = "[x, y, z], each from -1e9 to 1e9";
    channels(key, values, |x| x.abs() <= LARGEST, expected).map(DVec3::from)
}

/// A direction of any length but zero, returned with length 1.
pub(super) fn direction(key: &str, values: [f64; 3]) -> Checked<DVec3> {
    let expected = "[x, y, z] of any length but zero";
    let vector = DVec3::from(channels(key, values, |_| true, expected)?);
    let largest = vector.abs().max_element();
    if largest == 0.0 {
        let fault = Input::new("a direction of length zero").key(key);
        return Err(fault.found(list(&values)).expected(expected));
    }
    Ok((vector / largest).normalize())
}

/// `[a, b, c]`, as the user would write it.
fn list(values: &[f64; 3]) -> String {
    format!("[{}, {}, {}]", values[0], values[1], values[2])
}

fn fault_in(values: [f64; 3], accept: &impl Fn(f64) -> bool) -> Option<&'static str> {
    if values.iter().any(|x| !x.is_finite()) {
        Some("not a finite number")
    } else if values.iter().any(|&x| !accept(x)) {
        Some("out of range")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_what_is_wrong_with_a_number() {
        let positive = |x| number("camera.fov", x, |x| x > 0.0, "above 0").map_err(|e| e.to_string());
        assert_eq!(positive(2.0), Ok(2.0));
        assert_eq!(positive(-1.0), Err("camera.fov: out of range; found -1; expected above 0".into()));
        assert_eq!(positive(f64::NAN), Err("camera.fov: not a finite number; found NaN; expected above 0".into()));
    }

    #[test]
    fn directions_of_any_length_become_unit() {
        for length in [1e-300, 1.0, 1e300] {
            let unit = direction("d", [0.0, length, length]).map(|d| (d.length() - 1.0).abs());
            assert!(unit.is_ok_and(|error| error < 1e-12));
        }
        let zero = direction("light.0.direction", [0.0; 3]).map_err(|e| e.to_string());
        assert!(zero.is_err_and(|e| e.contains("light.0.direction: a direction of length zero")));
    }
}
