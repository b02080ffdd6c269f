//! Margins: the texels around an island, filled from the surface across its border.

use glam::DVec2;
use rayon::prelude::*;

use super::walk::{Across, Faces, weights};
use super::{LEAST, NONE};

/// The texels of an island and its margin.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    faces: Vec<u32>,
    /// The half-edges of the island's border.
    pub border: Vec<u32>,
    /// The corners of the bounding box, texels.
    low: DVec2,
    high: DVec2,
    /// Areas of the island, in texels and in scene units.
    areas: [f64; 2],
    /// Width of the margin.
    pub wide: u32,
}

impl Sheet {
    /// Adds a triangle to the island.
    pub fn hold(&mut self, face: u32, faces: &Faces<'_>) {
        let [a, b, c] = faces.places[face as usize];
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let first = self.faces.is_empty();
        (self.low, self.high) = if first { (low, high) } else { (self.low.min(low), self.high.max(high)) };
        self.areas[0] += 0.5 * (b - a).perp_dot(c - a).abs();
        let [p, q, r] = faces.mesh.triangles[face as usize].map(|v| faces.mesh.positions[v as usize]);
        self.areas[1] += 0.5 * (q - p).cross(r - p).length();
        self.faces.push(face);
    }

    /// Width of the margin that covers `share` of the length `reach` (scene units) at this island's scale, in texels.
    pub fn margin(&self, reach: f64, share: f64) -> f64 {
        let density = (self.areas[0] / self.areas[1].max(f64::MIN_POSITIVE)).sqrt();
        (reach * share * density).ceil().clamp(LEAST, 1e5)
    }

    /// Number of texels, with a margin of this width.
    pub fn texels(&self, margin: f64) -> f64 {
        let size = self.high.ceil() - self.low.floor() + 1.0 + 2.0 * margin;
        size.x * size.y
    }

    /// Number of texel tests to find the covered texels and, in a margin of this width, the nearest border edges.
    pub fn work(&self, faces: &Faces<'_>, margin: f64) -> f64 {
        let area = |low: DVec2, high: DVec2| (high - low + 1.0).element_product();
        let of_face = |&face: &u32| {
            let [a, b, c] = faces.places[face as usize];
            area(a.min(b).min(c), a.max(b).max(c))
        };
        let of_edge = |&half: &u32| {
            let [p, q] = faces.ends(half);
            area(p.min(q) - margin - 1.0, p.max(q) + margin + 1.0)
        };
        self.faces.iter().map(of_face).sum::<f64>() + self.border.iter().map(of_edge).sum::<f64>()
    }

    /// Sets the margin's width and adds it to the bounding box.
    pub fn place(&mut self, margin: f64) {
        self.wide = margin as u32;
        (self.low, self.high) = (self.low.floor() - margin, self.high.ceil() + margin);
    }

    /// The centre of the first texel; valid after `place`.
    pub fn low(&self) -> DVec2 {
        self.low
    }

    /// Width and height in texels; valid after `place`.
    pub fn size(&self) -> (usize, usize) {
        let size = self.high - self.low;
        (size.x as usize + 1, size.y as usize + 1)
    }

    /// Index of a texel in row order, if it lies in the sheet.
    fn index(&self, at: DVec2) -> Option<usize> {
        let inside = at.cmpge(self.low).all() && at.cmple(self.high).all();
        let from = at - self.low;
        inside.then(|| from.y as usize * self.size().0 + from.x as usize)
    }

    /// Calls `visit` for each texel of the sheet between two corners.
    fn each(&self, low: DVec2, high: DVec2, mut visit: impl FnMut(usize, DVec2)) {
        let (low, high) = (low.max(self.low).ceil(), high.min(self.high).floor());
        for y in low.y as i64..=high.y as i64 {
            for x in low.x as i64..=high.x as i64 {
                let at = DVec2::new(x as f64, y as f64);
                self.index(at).into_iter().for_each(|index| visit(index, at));
            }
        }
    }

    /// Which texels are covered by a triangle.
    fn covered(&self, faces: &Faces<'_>) -> Vec<bool> {
        let mut covered = vec![false; self.size().0 * self.size().1];
        for &face in &self.faces {
            let places = faces.places[face as usize];
            let [a, b, c] = places;
            self.each(a.min(b).min(c), a.max(b).max(c), |index, at| {
                covered[index] |= weights(places, at).is_some_and(|w| w.iter().all(|&w| w >= -1e-9));
            });
        }
        covered
    }

    /// For each texel outside the triangles, the nearest edge of the border; of two that meet at the nearest corner,
    /// the one whose line is farther away.
    fn nearest(&self, faces: &Faces<'_>, covered: &[bool]) -> Vec<u32> {
        let mut best = vec![(f64::INFINITY, 0.0, NONE); covered.len()];
        for &half in &self.border {
            let [p, q] = faces.ends(half);
            let (edge, wide) = (q - p, f64::from(self.wide) + 1.0);
            if edge == DVec2::ZERO {
                continue;
            }
            self.each(p.min(q) - wide, p.max(q) + wide, |index, at| {
                if covered[index] {
                    return;
                }
                let along = ((at - p).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
                let (d2, out) = (at.distance_squared(p + along * edge), (at - p).perp_dot(edge).abs() / edge.length());
                let [far, before] = [best[index].0, best[index].1];
                if d2 < far - 1e-9 || (d2 < far + 1e-9 && out > before) {
                    best[index] = (d2, out, half);
                }
            });
        }
        best.into_iter().map(|(_, _, half)| half).collect()
    }
}

/// The texels of each sheet, rows from the top, `runs` maps one after another. `islands` is the island of each
/// triangle; `user_texel` is a texel of the user's maps, by column, row and map.
pub fn fill(
    faces: &Faces<'_>,
    sheets: &[Sheet],
    islands: &[u32],
    runs: usize,
    user_texel: &(impl Fn(i64, i64, usize) -> [f32; 4] + Sync),
) -> Vec<Vec<[f32; 4]>> {
    let covered: Vec<Vec<bool>> = sheets.par_iter().map(|sheet| sheet.covered(faces)).collect();
    let texel = |at: DVec2, run: usize| user_texel(at.x as i64, at.y as i64, run);

    // Bilinear look-up at a point of a triangle, from texels that its island covers if there are any.
    let looked = |face: u32, weight: [f64; 3], run: usize| {
        let (island, places) = (islands[face as usize] as usize, faces.places[face as usize]);
        let at: DVec2 = (0..3).map(|k| weight[k] * places[k]).sum();
        let (low, part) = (at.floor(), at - at.floor());
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|step| {
            let share = (1.0 - step + (2.0 * step - 1.0) * part).to_array();
            let at = low + step;
            let has = sheets[island].index(at).is_some_and(|index| covered[island][index]);
            (texel(at, run), share[0] * share[1], has)
        });
        let sum = |all: bool| {
            let counted = corners.iter().filter(|corner| all || corner.2);
            counted.fold(([0.0; 4], 0.0), |(sum, total), (texel, share, _)| {
                (std::array::from_fn(|c| sum[c] + share * f64::from(texel[c])), total + share)
            })
        };
        let (sum, total) = Some(sum(false)).filter(|(_, total)| *total > 1e-3).unwrap_or_else(|| sum(true));
        sum.map(|x: f64| (x / total) as f32)
    };
    let of_sheet = |(sheet, covered): (&Sheet, &Vec<bool>)| {
        let width = sheet.size().0;
        let nearest = sheet.nearest(faces, covered);
        let place = |index: usize| sheet.low + DVec2::new((index % width) as f64, (index / width) as f64);
        let across = |(index, &half): (usize, &u32)| match half {
            NONE => Across::Open,
            half => faces.across(half, place(index)),
        };
        let across: Vec<Across> = nearest.par_iter().enumerate().map(across).collect();
        let value = |(index, across): (usize, &Across), run: usize| match *across {
            Across::Face(face, weight) => looked(face, weight, run),
            Across::Open | Across::Unknown => texel(place(index), run),
        };
        (0..runs)
            .flat_map(|run| across.iter().enumerate().map(move |entry| (entry, run)))
            .map(|(entry, run)| value(entry, run))
            .collect()
    };
    sheets.par_iter().zip(&covered).map(of_sheet).collect()
}
