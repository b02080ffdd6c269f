//! Stage `points`: where the picture shows an object, 16 places a tile of 4 x 4 pixels, as receivers of light: radiosity
//! depends on the place only, so it can be had right there instead of between the vertices.
//!
//! Pixels of a tile that show something else take the place of one that shows the object; a tile that shows nothing of it
//! lies so far off that no light is worth carrying there.

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::refit::{SPHERE, disc, sphere};
use crate::layout::{Block, Camera, Slot};
use crate::state::{Pass, Place, Role, Stage, State, Tolerance, Unit, narrow, wide};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "points",
    room: "view",
    about: "receivers where the pixels show the object, in blocks of 4 x 4",
    equation: "the hit triangle's corners by their weights",
    writes: &[
        (Slot::places, Role::Output, Tolerance::Float { relative: 0.0, floor: 4e-6 }),
        (Slot::spheres, Role::Output, Tolerance::Fields(SPHERE)),
    ],
    reason: "weights times corners, a few roundings of the extent",
    unit: Unit::Object,
    cpu,
    gpu,
};

/// Pixels along a side of a tile.
const SIDE: u32 = 4;
/// Places of a tile.
pub const PLACES: u32 = SIDE * SIDE;
/// Where a tile is that shows nothing of the object: farther from all of it than any table of distances goes.
const NOWHERE: [f32; 3] = [16.0; 3];

/// Tiles of a picture of this size.
#[must_use]
pub fn tiles([width, height]: [u32; 2]) -> u32 {
    width.div_ceil(SIDE) * height.div_ceil(SIDE)
}

/// The receiver of a pixel, by its column and row.
#[must_use]
pub fn receiver(width: u32, column: u32, row: u32) -> u32 {
    let tile = row / SIDE * width.div_ceil(SIDE) + column / SIDE;
    PLACES * tile + row % SIDE * SIDE + column % SIDE
}

/// The pixel of a place, if the picture reaches so far.
fn pixel(camera: &Camera, tile: u32, k: u32) -> Option<usize> {
    let across = camera.width.div_ceil(SIDE);
    let (column, row) = (tile % across * SIDE + k % SIDE, tile / across * SIDE + k / SIDE);
    (column < camera.width && row < camera.height).then(|| (row * camera.width + column) as usize)
}

fn cpu(state: &mut State, _at: Place) {
    let data = &state.data;
    let (frame, camera) = (&data.frame[0], &data.camera[0]);
    let shown = |tile: u32, k: u32| {
        let hit = data.hits[pixel(camera, tile, k)?];
        let corners = data.triangles.get(hit.face.checked_sub(frame.first_face)? as usize)?;
        let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
        Some(narrow(corners.iter().zip(weight).map(|(&v, w)| w * wide(data.positions[v as usize])).sum()))
    };
    let disc = disc(f64::from(data.clusters[0].area), frame.blocks);
    let of_tile = |tile: u32| {
        let places: [Option<[f32; 3]>; PLACES as usize] = std::array::from_fn(|k| shown(tile, k as u32));
        let other = places.iter().copied().flatten().next().unwrap_or(NOWHERE);
        let places = places.map(|place| place.unwrap_or(other));
        let block = Block { node: 0, first: 0, count: PLACES };
        (places, sphere(&block, disc, |k| wide(places[k])))
    };
    let (places, spheres): (Vec<_>, Vec<_>) = (0..frame.blocks).into_par_iter().map(of_tile).unzip();
    (state.data.places, state.data.spheres) = (places.concat(), spheres);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.blocks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_a_place_of_its_own() {
        let camera = Camera { width: 10, height: 7, ..Camera::default() };
        let mut seen = vec![None; 70];
        for place in 0..PLACES * tiles([10, 7]) {
            if let Some(pixel) = pixel(&camera, place / PLACES, place % PLACES) {
                assert_eq!(receiver(10, pixel as u32 % 10, pixel as u32 / 10), place);
                assert_eq!(seen[pixel].replace(place), None);
            }
        }
        assert!(seen.iter().all(Option::is_some));
    }
}
