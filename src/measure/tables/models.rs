//! Models for the tables: built-in shapes with triangle counts close to the paper's, and meshes from files. Also fits
//! the solid angles, which the paper does not give, to its number of links per triangle.

use crate::error::Result;
use crate::gpu::Device;
use crate::scene::{ClusterForm, Scene, Shape};

use super::solve::{Kept, Solved};

/// Marble in the sun, in the scheme as published.
const SETTINGS: [&str; 2] = ["object.0.material.preset=marble", "transport.scheme=links"];

/// A built-in shape of `extent` millimetres with about `faces` triangles.
pub fn shape(name: &str, faces: usize, extent: f64) -> Result<Scene> {
    built(name, detail(kind_of(name), faces), extent, &[])
}

/// The shape of this name.
fn kind_of(name: &str) -> Shape {
    match name {
        "lotus" => Shape::Lotus,
        "slab" => Shape::Slab,
        _ => Shape::Sphere,
    }
}

/// A built-in shape with these settings beside those of the tables.
fn built(name: &str, detail: u32, extent: f64, more: &[String]) -> Result<Scene> {
    let own =
        [format!("object.0.shape={name}"), format!("object.0.detail={detail}"), format!("object.0.size={extent}")];
    let mut scene = Scene::load_with("sphere", &[&own[..], more, &SETTINGS.map(String::from)].concat())?;
    scene.name = name.to_string();
    Ok(scene)
}

/// A built-in shape from a coarse base, split at most `levels` times by the modified butterfly scheme, which is also
/// its hierarchy: about `faces` triangles at the end.
pub fn split(name: &str, faces: usize, levels: usize, extent: f64) -> Result<Scene> {
    let (levels, detail) = base(kind_of(name), faces, levels);
    let hierarchy = ["transport.hierarchy=butterfly".into(), format!("transport.levels={levels}")];
    built(name, detail, extent, &hierarchy)
}

/// A mesh from a file, scaled to this largest extent in millimetres, with the same settings.
pub fn mesh(path: &str, extent: f64) -> Result<Scene> {
    let own = [format!("object.0.size={extent}")];
    Scene::load_with(path, &[&own[..], &SETTINGS.map(String::from)].concat())
}

/// Triangles of a shape with this detail.
fn count(shape: Shape, detail: u32) -> f64 {
    shape.build(detail).triangles.len() as f64
}

/// How often a base is split, at most `most` times, and its detail, for the number of triangles closest to `faces`, by
/// ratio: a shape that cannot be coarse is split less often. Of equally close bases it is the one with most splits.
fn base(shape: Shape, faces: usize, most: usize) -> (usize, u32) {
    let tried = |levels: usize| (levels, detail(shape, faces >> (2 * levels)));
    let off =
        |(levels, detail): &(usize, u32)| (count(shape, *detail) * 4f64.powi(*levels as i32) / faces as f64).ln().abs();
    (1..=most).rev().map(tried).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_else(|| (0, detail(shape, faces)))
}

/// The detail whose number of triangles is closest to `faces`, by ratio.
fn detail(shape: Shape, faces: usize) -> u32 {
    let (range, wanted) = (shape.details(), faces.max(1) as f64);
    // Counts grow with the detail: find the first that is enough, without building much larger shapes.
    let (mut below, mut enough) = (*range.start(), *range.start());
    while count(shape, enough) < wanted && enough < *range.end() {
        below = enough;
        enough = (enough + (enough / 2).max(1)).min(*range.end());
    }
    while enough - below > 1 {
        let middle = below.midpoint(enough);
        if count(shape, middle) < wanted { below = middle } else { enough = middle }
    }
    let off = |detail: u32| (count(shape, detail) / wanted).ln().abs();
    if off(below) <= off(enough) { below } else { enough }
}

/// The value for both solid angles of section 5.2, steradian, at which this scene has this many links per triangle.
pub fn angle(scene: &Scene, device: Option<&Device>, links_per_face: f64) -> Result<f64> {
    let (mut fine, mut coarse) = (1e-2f64, 10.0f64);
    // Links are chosen alike however clusters are evaluated; one sample is the fastest.
    let mut sampled = scene.clone();
    sampled.transport.cluster = Some(ClusterForm::Sample);
    for _ in 0..9 {
        let middle = (fine * coarse).sqrt();
        let solved = Solved::new(&at_angle(&sampled, middle), device, Kept::Nothing)?;
        if solved.links_per_face() > links_per_face { fine = middle } else { coarse = middle }
    }
    Ok((fine * coarse).sqrt())
}

/// The scene with both solid angles set to this value.
#[must_use]
pub fn at_angle(scene: &Scene, angle: f64) -> Scene {
    let mut scene = scene.clone();
    (scene.transport.receiver_angle, scene.transport.emitter_angle) = (angle, angle);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_have_the_triangles_of_the_paper_even_where_no_base_is_coarse_enough() {
        use super::super::paper::{TABLE_3, TABLE_4};
        let rows = (2..).zip(TABLE_3.iter().map(|row| row.faces));
        let all = rows.flat_map(|(levels, faces)| [("sphere", faces, levels), ("lotus", faces, levels)]);
        let of_4 = TABLE_4.iter().filter(|row| row.hierarchy == "S").map(|row| (row.stand_in, row.faces, 3));
        for (name, faces, most) in all.chain(of_4) {
            let (levels, detail) = base(kind_of(name), faces, most);
            let found = count(kind_of(name), detail) * 4f64.powi(levels as i32);
            // Balls have four times as many from detail to detail.
            let slack = if name == "sphere" { 2.0 } else { 1.1 };
            assert!((1..=most).contains(&levels), "{name}: {levels}");
            assert!((1.0 / slack..slack).contains(&(found / faces as f64)), "{name}: {found} for {faces}");
        }
        let scene = split("lotus", TABLE_3[0].faces, 2, 25.0).unwrap();
        assert!((1800..2300).contains(&scene.objects[0].mesh.triangles.len()));
        assert_eq!([0, 1, 126].map(|faces| detail(Shape::Lotus, faces)), [*Shape::Lotus.details().start(); 3]);
    }

    #[test]
    fn shapes_have_the_triangles_asked_for() {
        for (name, asked, slack) in [("lotus", 8764, 0.05), ("slab", 2016, 0.08), ("sphere", 5000, 0.03)] {
            let scene = shape(name, asked, 40.0).unwrap();
            let found = scene.objects[0].mesh.triangles.len() as f64;
            assert!((found / asked as f64 - 1.0).abs() < slack, "{name}: {found} for {asked}");
            let (low, high) = scene.objects[0].mesh.bounds();
            assert!(((high - low).max_element() - 40.0).abs() < 1e-9);
        }
    }
}
