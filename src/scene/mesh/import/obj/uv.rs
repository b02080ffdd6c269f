//! Texture coordinates and normals: `vt` and `vn` statements, and the corners of faces that refer to them.

use super::{MOST_UV, statements};
use crate::error::Input;
use crate::scene::range::Checked;
use glam::DVec3;

/// Texture coordinates of each triangle's corners. `cuts` are the face of each triangle, in the order of the file, and
/// the corners of the face that it has. An error carries its line.
pub(super) fn corners(text: &str, cuts: impl Iterator<Item = (u32, [u32; 3])>) -> Checked<Vec<[[f64; 2]; 3]>> {
    let mut places = Vec::new();
    let mut named: Vec<(usize, Vec<i64>)> = Vec::new();
    for (line, statement) in statements(text) {
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("vt") => places.push(place(words).map_err(|fault| fault.line(line))?),
            Some("f") => {
                let numbers = words.map(|word| index(word, places.len()));
                named.push((line, numbers.collect::<Checked<_>>().map_err(|fault| fault.line(line))?));
            }
            _ => {}
        }
    }

    // Look up coordinates last: a face may refer to a later `vt`.
    let mut faces = Vec::with_capacity(named.len());
    for (line, numbers) in named {
        let at = |number: &i64| {
            usize::try_from(*number).ok().and_then(|number| places.get(number)).copied().ok_or_else(|| {
                let fault = Input::new("a face names a texture coordinate that is not there").line(line);
                let found = if *number < 0 { number - places.len() as i64 } else { number + 1 };
                fault.found(found).expected(format!("1 to {}", places.len()))
            })
        };
        faces.push(numbers.iter().map(at).collect::<Checked<Vec<_>>>()?);
    }
    Ok(cuts.map(|(face, cut)| cut.map(|corner| faces[face as usize][corner as usize])).collect())
}

/// Normals of each triangle's corners, by `cuts` as in [`corners`]; 0 where a corner names none, or none that is there.
/// None if no corner has one.
pub(super) fn normals(text: &str, cuts: impl Iterator<Item = (u32, [u32; 3])>) -> Option<Vec<[DVec3; 3]>> {
    let mut all = Vec::new();
    let mut named: Vec<Vec<Option<usize>>> = Vec::new();
    for (_, statement) in statements(text) {
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("vn") => {
                let mut number = || words.next().and_then(|word| word.parse().ok()).unwrap_or(f64::NAN);
                all.push(DVec3::new(number(), number(), number()));
            }
            Some("f") => {
                let index = |corner: &str| match corner.split('/').nth(2)?.parse::<i64>() {
                    Ok(number) if number > 0 => usize::try_from(number - 1).ok(),
                    Ok(number) => usize::try_from(number.checked_add(i64::try_from(all.len()).ok()?)?).ok(),
                    Err(_) => None,
                };
                named.push(words.map(index).collect());
            }
            _ => {}
        }
    }
    let normal = |number: &Option<usize>| number.and_then(|number| all.get(number)).copied();
    let faces: Vec<Vec<_>> = named.iter().map(|face| face.iter().map(normal).collect()).collect();
    let some = faces.iter().flatten().any(Option::is_some);
    let at = |face: u32, corner: u32| faces[face as usize][corner as usize].unwrap_or_default();
    some.then(|| cuts.map(|(face, cut)| cut.map(|corner| at(face, corner))).collect())
}

/// The first two numbers of a `vt` statement; the second defaults to 0.
fn place<'a>(words: impl Iterator<Item = &'a str>) -> Checked<[f64; 2]> {
    let words: Vec<&str> = words.take(2).collect();
    let number = |word: &str| word.parse().ok().filter(|x: &f64| x.abs() <= MOST_UV);
    let read = |k: usize| words.get(k).map_or(Some(0.0), |word| number(word));
    match (words.is_empty(), read(0), read(1)) {
        (false, Some(u), Some(v)) => Ok([u, v]),
        _ => {
            let fault = Input::new("not a texture coordinate").found(format!("`{}`", words.join(" ")));
            Err(fault.expected("two numbers from -10,000 to 10,000"))
        }
    }
}

/// The texture coordinate that a corner such as `7/2` or `7/-1/3` refers to, from 0, when `before` of them precede.
fn index(corner: &str, before: usize) -> Checked<i64> {
    let what = corner.split('/').nth(1).unwrap_or_default();
    match what.parse::<i64>() {
        Ok(number) if number > 0 => Ok(number - 1),
        Ok(number) if number < 0 => Ok(number.saturating_add(before as i64)),
        _ => {
            let fault = Input::new("the mesh has no texture coordinates, or not at every corner");
            Err(fault.found(format!("`{corner}`")).expected("corners such as 7/2 or 7/2/3"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_have_their_own_places() {
        let text = "vt 0 0\nvt 1 0 9\nv 1 2 3\nf 1/1 2/2/5 3/3 4/-1\nvt 0.5\nvt 0 1\nf 1/-1/1 2/-2 3/2\n";
        let cuts = [(0, [0, 1, 2]), (0, [0, 2, 3]), (1, [0, 1, 2])];
        let found = corners(text, cuts.into_iter()).expect("three triangles");
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [0.0, 1.0]];
        assert_eq!(found, [[a, b, c], [a, c, b], [d, c, b]]);
    }

    #[test]
    fn normals_that_are_not_there_do_not_matter() {
        let text = "vn 0 0 1\nvn 0 2 0\nf 1//1 2/7/2 3//-1 4/1\nvn x\nf 1//9 2//0 3//3\nf 1//-9 2//y 3//2\n";
        let cuts = [(0, [0, 1, 2]), (0, [0, 2, 3]), (1, [0, 1, 2]), (2, [0, 1, 2])];
        let found = normals(text, cuts.into_iter()).expect("normals");
        let [none, z, y] = [DVec3::ZERO, DVec3::Z, 2.0 * DVec3::Y];
        assert_eq!(found[..2], [[z, y, y], [z, y, none]]);
        // Index 0 is no corner's, and the third normal is no direction.
        assert!(found[2][0] == none && found[2][2].is_nan());
        assert_eq!(found[3], [none, none, y]);
        assert_eq!(normals("vn 0 0 1\nf 1 2/1 3//\n", [(0, [0, 1, 2])].into_iter()), None);
    }

    #[test]
    fn faults_have_their_line() {
        let cases = [
            (
                "f 1 2 3",
                "the mesh has no texture coordinates, or not at every corner; found `1`; expected corners such",
            ),
            ("f 1/1 2/1 3//1", "the mesh has no texture coordinates, or not at every corner; found `3//1`"),
            ("f 1/1 2/1 3/2", "a face names a texture coordinate that is not there; found 2; expected 1 to 1"),
            ("f 1/1 2/-2 3/1", "a face names a texture coordinate that is not there; found -2"),
            ("vt", "not a texture coordinate; found ``; expected two numbers"),
            ("vt x", "not a texture coordinate; found `x`"),
            ("vt 0 nan", "not a texture coordinate; found `0 nan`"),
            ("vt 0 10001", "not a texture coordinate; found `0 10001`"),
        ];
        for (statement, expected) in cases {
            let error = corners(&format!("vt 0 0\n{statement}\n"), std::iter::empty()).expect_err(statement);
            assert!(error.line == Some(2) && error.to_string().starts_with(expected), "{error}");
        }
    }
}
