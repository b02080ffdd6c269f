//! Islands: the pieces into which seams divide a mesh's texture coordinates. The march continues in texture space;
//! beyond a seam the texels belong to nothing or to another part of the surface.
//!
//! For a mesh with seams the maps are rearranged once, when the scene is loaded. Each island is moved by whole
//! texels, so that the texels of its triangles keep their values, and gets a margin filled from across its border
//! (`margin`), as wide as rays reach or as memory allows. Beyond the margin its outermost texels repeat. The user's
//! maps are not changed.

mod margin;
mod walk;

use std::collections::VecDeque;

use glam::DVec2;

use crate::layout::Island;
use crate::lighting::texture::texel;
use crate::scene::{DepthMap, Mesh};
use margin::Sheet;
use walk::Faces;

/// No half-edge.
const NONE: u32 = u32::MAX;
/// Largest distance between equal positions in the maps, in texels.
const SAME: f64 = 1e-2;
/// Most texels of islands and margins, over all maps; or twice the number of the user's texels if that is more.
const MOST: usize = 1 << 21;
/// Most texel tests for all triangles and borders together.
const MOST_WORK: f64 = (1u64 << 33) as f64;
/// Narrowest margin, in texels: enough for bilinear look-ups.
const LEAST: f64 = 2.0;

/// A mesh's maps, rearranged by islands.
#[derive(Clone, Debug, PartialEq)]
pub struct Atlas {
    /// Width and height, in texels.
    pub size: [u32; 2],
    /// The depths, in the layout of [`DepthMap::texels`].
    pub texels: Vec<[f32; 4]>,
    /// For each triangle of the mesh, its corners' positions in the atlas and the bounds of its island there.
    pub places: Vec<Island>,
    /// Number of islands.
    pub islands: usize,
    /// Edges at which islands meet.
    pub seams: usize,
    /// Widest margin, in texels.
    pub margin: u32,
    /// The share of the requested reach that the margins cover, 0 to 1.
    pub share: f64,
}

/// Why a mesh's maps are used unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whole {
    /// Its texture coordinates are continuous across every edge.
    Seamless,
    /// Even with the narrowest margins the islands take this many texels, which exceeds the limit.
    TooLarge(usize),
    /// Its triangles overlap in the maps so much that filling the atlas would take too long.
    TooFolded,
}

/// The mesh's maps by islands, each with a margin wide enough for rays of length `reach` (scene units).
///
/// An edge is a seam if its two triangles have different texture coordinates at both ends, up to whole periods. In a
/// mesh with seams, an edge with different coordinates at one end also separates islands. Beyond an open edge the
/// maps keep their own texels.
pub fn atlas(mesh: &Mesh, map: &DepthMap, reach: f64) -> Result<Atlas, Whole> {
    let Some(uvs) = &mesh.uvs else { return Err(Whole::Seamless) };
    let size = DVec2::new(map.size[0].into(), map.size[1].into());
    let place = |[u, v]: [f64; 2]| DVec2::new(u, 1.0 - v) * size - 0.5;
    let mut faces = Faces { mesh, twins: mesh.twins(), places: uvs.iter().map(|uvs| uvs.map(place)).collect() };
    let period = map.wrap.period().map(|sides| sides * size);
    let (moves, seams) = crossings(&faces, period);
    if seams == 0 {
        return Err(Whole::Seamless);
    }
    let (of, islands) = flood(&mut faces, &moves, period);
    let mut sheets = sheets(&faces, &moves, &of, islands);
    let share = share(&faces, &sheets, map, reach)?;
    sheets.iter_mut().for_each(|sheet| sheet.place(sheet.margin(reach, share)));
    let (size, corners) = pack(&sheets);
    let texels = fill(&faces, &sheets, &of, map, (size, &corners));
    let island = |(face, places): (usize, &[DVec2; 3])| {
        let (sheet, corner) = (&sheets[of[face] as usize], corners[of[face] as usize].map(f64::from));
        let by = DVec2::from_array(corner) - sheet.low();
        let [a, b, c] = places.map(|p| (p + by).as_vec2().to_array());
        let (width, height) = sheet.size();
        let last = [corner[0] + width as f64 - 1.0, corner[1] + height as f64 - 1.0];
        Island { a, b, c, low: corner.map(|x| x as f32), high: last.map(|x| x as f32) }
    };
    let places = faces.places.iter().enumerate().map(island).collect();
    let margin = sheets.iter().map(|sheet| sheet.wide).max().unwrap_or(0);
    Ok(Atlas { size, texels, places, islands: islands as usize, seams: seams / 2, margin, share })
}

/// A distance in the maps rounded to whole periods.
fn whole(d: DVec2, period: Option<DVec2>) -> DVec2 {
    period.map_or(DVec2::ZERO, |period| (d / period).round() * period)
}

/// For each half-edge the offset by whole periods across it, none where it separates islands; and the number of those
/// at seams.
fn crossings(faces: &Faces<'_>, period: Option<DVec2>) -> (Vec<Option<DVec2>>, usize) {
    let mut moves = vec![None; 3 * faces.places.len()];
    let mut seams = 0;
    for half in 0..moves.len() as u32 {
        let Some(apart) = faces.apart(half) else { continue };
        let by = whole(apart[0], period);
        let far = |d: DVec2, by: DVec2| (d - by).abs().max_element() > SAME;
        seams += usize::from(apart.iter().all(|&d| far(d, whole(d, period))));
        if !apart.iter().any(|&d| far(d, by)) {
            moves[half as usize] = Some(by);
        }
    }
    (moves, seams)
}

/// The island of each triangle, and their number. Triangles of an island are moved together by whole periods.
fn flood(faces: &mut Faces<'_>, moves: &[Option<DVec2>], period: Option<DVec2>) -> (Vec<u32>, u32) {
    let before: Vec<DVec2> = faces.places.iter().map(|places| places[0]).collect();
    let mut of = vec![NONE; before.len()];
    let mut islands = 0;
    for first in 0..of.len() {
        if of[first] != NONE {
            continue;
        }
        of[first] = islands;
        let mut waiting = VecDeque::from([first]);
        while let Some(face) = waiting.pop_front() {
            for half in [3 * face, 3 * face + 1, 3 * face + 2] {
                let Some(by) = moves[half] else { continue };
                let next = faces.twins[half] as usize / 3;
                if of[next] == NONE {
                    of[next] = islands;
                    // `moves` refer to the original positions; this face has since been moved by whole periods.
                    let here = whole(faces.places[face][0] - before[face], period);
                    faces.places[next] = faces.places[next].map(|p| p + by + here);
                    waiting.push_back(next);
                }
            }
        }
        islands += 1;
    }
    (of, islands)
}

/// The triangles and the border of each island, without margins.
fn sheets(faces: &Faces<'_>, moves: &[Option<DVec2>], of: &[u32], islands: u32) -> Vec<Sheet> {
    let closes = |half: usize| moves[half].is_some() && faces.apart(half as u32).is_some_and(|d| d[0].length() < 1.0);
    let mut sheets = vec![Sheet::default(); islands as usize];
    for (face, &island) in of.iter().enumerate() {
        sheets[island as usize].hold(face as u32, faces);
    }
    for half in (0..moves.len()).filter(|&half| !closes(half)) {
        sheets[of[half / 3] as usize].border.push(half as u32);
    }
    sheets
}

/// The maps that a depth map has, one below another.
fn runs(map: &DepthMap) -> usize {
    map.texels.len() / (map.size[0] as usize * map.size[1] as usize).max(1)
}

/// The largest share of the reach that margins can cover within the limits.
fn share(faces: &Faces<'_>, sheets: &[Sheet], map: &DepthMap, reach: f64) -> Result<f64, Whole> {
    let (runs, most) = (runs(map) as f64, MOST.max(2 * map.texels.len()) as f64);
    let texels = |share: f64| sheets.iter().map(|sheet| sheet.texels(sheet.margin(reach, share))).sum::<f64>() * runs;
    let work = |share: f64| sheets.iter().map(|sheet| sheet.work(faces, sheet.margin(reach, share))).sum::<f64>();
    let fits = |share: &f64| texels(*share) <= most && work(*share) <= MOST_WORK;
    (0..40).map(|k| 0.8f64.powi(k)).chain([0.0]).find(fits).ok_or_else(|| {
        let texels = texels(0.0);
        if texels > most { Whole::TooLarge(texels as usize) } else { Whole::TooFolded }
    })
}

/// The texels of an atlas of this size, whose islands have their upper left corners there.
fn fill(
    faces: &Faces<'_>,
    sheets: &[Sheet],
    of: &[u32],
    map: &DepthMap,
    (size, corners): ([u32; 2], &[[u32; 2]]),
) -> Vec<[f32; 4]> {
    let (wrap, runs) = (map.wrap.code(), runs(map));
    let mapped = |x: i64, y: i64, run: usize| {
        let row = texel(y, map.size[1], wrap) as usize + run * map.size[1] as usize;
        map.texels[row * map.size[0] as usize + texel(x, map.size[0], wrap) as usize]
    };
    let mut all = vec![[0.0; 4]; size[0] as usize * size[1] as usize * runs];
    for (number, part) in margin::fill(faces, sheets, of, runs, &mapped).into_iter().enumerate() {
        let (width, height) = sheets[number].size();
        for (row, line) in part.chunks_exact(width).enumerate() {
            let (run, y) = (row / height, row % height + corners[number][1] as usize);
            let at = (run * size[1] as usize + y) * size[0] as usize + corners[number][0] as usize;
            all[at..at + width].copy_from_slice(line);
        }
    }
    all
}

/// Packs the islands in rows, the highest first: the atlas's size and the upper left corner of each island.
fn pack(sheets: &[Sheet]) -> ([u32; 2], Vec<[u32; 2]>) {
    let sizes: Vec<(usize, usize)> = sheets.iter().map(Sheet::size).collect();
    let area: usize = sizes.iter().map(|(width, height)| width * height).sum();
    let widest = sizes.iter().map(|size| size.0).max().unwrap_or(1);
    let across = widest.max((1.1 * (area as f64).sqrt()) as usize);
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&number| std::cmp::Reverse(sizes[number].1));
    let (mut corners, mut x, mut y, mut high) = (vec![[0; 2]; sizes.len()], 0, 0, 0);
    for number in order {
        let (width, height) = sizes[number];
        if x + width > across {
            (x, y, high) = (0, y + high, 0);
        }
        corners[number] = [x as u32, y as u32];
        (x, high) = (x + width, high.max(height));
    }
    ([across as u32, (y + high) as u32], corners)
}
