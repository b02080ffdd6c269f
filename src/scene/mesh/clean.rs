//! Cleaning: one vertex per position, no face without area, no face twice, no vertex without a face. Repairs are
//! counted and reported.

use super::Mesh;
use super::import::Soup;
use super::twice;
use crate::error::Input;
use crate::scene::range::Checked;
use glam::DVec3;
use rayon::slice::ParallelSliceMut;

/// A face with at most this area, relative to its longest edge squared, is degenerate.
const SLIVER: f64 = 1e-7;

/// The cleaned mesh, with faces in the order of the input, and for each of its vertices the number of the input's
/// vertex. Open edges are not counted yet.
pub(super) fn clean(soup: Soup, report: &mut Vec<String>) -> Checked<(Mesh, Vec<u32>)> {
    let Soup { positions, triangles, input_face, uvs, normals, unused, notes } = soup;
    report.extend(notes);
    let (first, welded) = weld(&positions);

    // Keep faces with three different corners and an area.
    let mut mesh = Mesh { uvs: uvs.as_ref().map(|_| Vec::new()), ..Mesh::default() };
    mesh.corner_normals = normals.as_ref().map(|_| Vec::new());
    let (mut repeated, mut slivers) = (0, 0);
    for (triangle, (corners, face)) in triangles.iter().zip(input_face).enumerate() {
        let [a, b, c] = corners.map(|corner| first[corner as usize]);
        if a == b || b == c || c == a {
            repeated += 1;
        } else if is_sliver([a, b, c].map(|corner| positions[corner as usize])) {
            slivers += 1;
        } else {
            mesh.triangles.push([a, b, c]);
            mesh.input_face.push(face);
            if let (Some(kept), Some(all)) = (&mut mesh.uvs, &uvs) {
                kept.push(all[triangle]);
            }
            if let (Some(kept), Some(all)) = (&mut mesh.corner_normals, &normals) {
                kept.push(all[triangle]);
            }
        }
    }
    if mesh.triangles.is_empty() {
        let found = format!("{repeated} with a repeated corner, {slivers} without area");
        let fault = Input::new("every face of the mesh is degenerate");
        return Err(fault.found(found).expected("at least one face with an area"));
    }

    // Keep the first of faces with the same corners: files made for both sides of a surface have each twice.
    let again = twice::find(&mesh.triangles, &mesh.input_face);
    let doubled = again.iter().filter(|&&is| is).count();
    if doubled > 0 {
        fn keep<T>(list: &mut Vec<T>, again: &[bool]) {
            let mut again = again.iter();
            list.retain(|_| again.next() != Some(&true));
        }
        keep(&mut mesh.triangles, &again);
        keep(&mut mesh.input_face, &again);
        mesh.uvs.iter_mut().for_each(|uvs| keep(uvs, &again));
        mesh.corner_normals.iter_mut().for_each(|normals| keep(normals, &again));
    }

    let from = renumber(&mut mesh, &positions);
    let unused = unused + (positions.len() - welded - mesh.positions.len());
    let repairs = [
        (welded, "welded", "vertices in the place of another one"),
        (repeated, "dropped", "faces with a repeated corner"),
        (slivers, "dropped", "faces without area"),
        (doubled, "dropped", "faces with the corners of an earlier one, as in files for both sides of a surface"),
        (unused, "dropped", "vertices that no face uses"),
    ];
    for (count, done, what) in repairs {
        if count > 0 {
            report.push(format!("{done}: {count} {what}"));
        }
    }
    Ok((mesh, from))
}

/// Numbers the vertices of a mesh in the order of first use; returns for each the one of `positions`.
fn renumber(mesh: &mut Mesh, positions: &[DVec3]) -> Vec<u32> {
    let mut number = vec![u32::MAX; positions.len()];
    let mut from = Vec::new();
    for corner in mesh.triangles.iter_mut().flatten() {
        let old = *corner as usize;
        if number[old] == u32::MAX {
            number[old] = u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX);
            mesh.positions.push(positions[old]);
            from.push(*corner);
        }
        *corner = number[old];
    }
    from
}

/// For each vertex the first one at the same position, and the number of duplicates.
pub(super) fn weld(positions: &[DVec3]) -> (Vec<u32>, usize) {
    // Adding 0 turns -0 into 0, so that equal coordinates have equal bits.
    let key = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut sorted: Vec<([u64; 3], u32)> = positions.iter().map(key).zip(0..).collect();
    sorted.par_sort_unstable();
    let mut first: Vec<u32> = (0..).take(positions.len()).collect();
    let mut welded = 0;
    for place in sorted.chunk_by(|a, b| a.0 == b.0) {
        for (_, other) in &place[1..] {
            first[*other as usize] = place[0].1;
            welded += 1;
        }
    }
    (first, welded)
}

/// Whether a triangle has (almost) no area for its size.
pub(super) fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    // Scale to about 1 first: squares of tiny or huge edges would leave the range of f64.
    let scale = ab.abs().max(bc.abs()).max(ca.abs()).max_element();
    let (ab, bc, ca) = (ab / scale, bc / scale, ca / scale);
    let longest = ab.length_squared().max(bc.length_squared()).max(ca.length_squared());
    let area = ab.cross(ca).length() / 2.0;
    // A scale of 0 makes the area NaN.
    area.is_nan() || area <= SLIVER * longest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Soup {
        Soup {
            positions: positions.iter().copied().map(DVec3::from_array).collect(),
            triangles: triangles.to_vec(),
            input_face: (0..).take(triangles.len()).collect(),
            ..Soup::default()
        }
    }

    #[test]
    fn welds_equal_places_and_minus_zero() {
        let corners =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, -0.0, 0.0], [1.0, 1.0, 0.0], [-0.0, 1.0, 0.0]];
        let mut report = Vec::new();
        let (mesh, from) = clean(soup(&corners, &[[0, 1, 2], [3, 4, 5]]), &mut report).expect("a square");
        assert_eq!(from, [0, 1, 2, 4]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(report, ["welded: 2 vertices in the place of another one"]);
    }

    #[test]
    fn drops_what_has_no_area_and_keeps_the_faces_numbers() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [5.0, 5.0, 5.0], [0.0, 1.0, 0.0]];
        let faces = [[0, 1, 2], [3, 3, 0], [0, 1, 4], [1, 2, 4]];
        let mut report = Vec::new();
        let uvs = Some((0..4).map(|face| [[f64::from(face); 2]; 3]).collect());
        let (mesh, _) = clean(Soup { uvs, ..soup(&corners, &faces) }, &mut report).expect("two faces");
        assert_eq!(mesh.input_face, [2, 3]);
        assert_eq!(mesh.uvs, Some(vec![[[2.0; 2]; 3], [[3.0; 2]; 3]]));
        assert_eq!(mesh.positions.len(), 4);
        let expected = [
            "dropped: 1 faces with a repeated corner",
            "dropped: 1 faces without area",
            "dropped: 1 vertices that no face uses",
        ];
        assert_eq!(report, expected);
    }

    #[test]
    fn of_faces_with_the_same_corners_the_first_stays() {
        // A quad both ways round, its back cut along the other diagonal, with vertices of its own; then a triangle of
        // the front once more, as it is.
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let corners = [square, square].concat();
        let faces = [[0, 1, 2], [0, 2, 3], [7, 6, 5], [7, 5, 4], [1, 2, 0]];
        let uvs = Some((0..5).map(|face| [[f64::from(face); 2]; 3]).collect());
        let soup = Soup { input_face: vec![0, 0, 1, 1, 2], uvs, ..soup(&corners, &faces) };
        let mut report = Vec::new();
        let (mesh, _) = clean(soup, &mut report).expect("a square");
        assert_eq!((mesh.triangles, mesh.input_face), (vec![[0, 1, 2], [0, 2, 3]], vec![0, 0]));
        assert_eq!(mesh.uvs.map(|uvs| uvs.len()), Some(2));
        let line = "dropped: 3 faces with the corners of an earlier one, as in files for both sides of a surface";
        assert_eq!(report, ["welded: 4 vertices in the place of another one", line]);
    }

    #[test]
    fn size_does_not_matter() {
        for scale in [1e-90, 1.0, 1e30] {
            let thin =
                |y: f64| is_sliver([[0.0, 0.0], [1.0, 0.0], [0.5, y]].map(|[x, y]| DVec3::new(x, y, 0.0) * scale));
            assert!(!thin(1e-3) && !thin(1e-6) && thin(1e-7) && thin(0.0), "{scale}");
        }
    }

    #[test]
    fn a_mesh_of_nothing_is_an_error() {
        let fault = clean(soup(&[[0.0; 3], [1.0; 3]], &[[0, 1, 1], [0, 0, 0]]), &mut Vec::new());
        let message = fault.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.starts_with("every face of the mesh is degenerate; found 2 with a rep"), "{message}");
    }
}
