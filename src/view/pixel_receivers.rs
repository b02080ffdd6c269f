//! Stage `pixel_receivers`: the visible points of an object as receivers of light. Radiosity depends on position
//! only, so it can be computed there instead of being interpolated between vertices.
//!
//! A tile of 4 x 4 pixels may show the object's edge and another part of it far behind. Its points are divided into
//! up to [`TILE_BLOCKS`] blocks, each a first point and the points near it, so that no block is much wider than a
//! tile of a slanted surface. Points near none of the four first points go into the last block; then no light is
//! expanded about its centre.

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::refit::{SPHERE, disc, sphere};
use crate::layout::{
    BLOCK_RECEIVERS, Block, BufferId, Camera, Hit, NOWHERE, Sphere, TILE_BLOCKS, TILE_REACH, TILE_SIDE,
    UNBOUNDED_SPREAD,
};
use crate::state::{
    Carrier, Granularity, Need, Pass, Role, Scope, Serves, Size, Stage, State, Tolerance, Update, wide,
};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "pixel_receivers",
    about: "receivers at the points that pixels show, grouped into blocks of nearby points in a tile of 4 x 4 pixels",
    equation: "the mean of the hit triangle's corners by their weights",
    writes: &[
        (BufferId::receiver_positions, Role::Output, Tolerance::Exact),
        (BufferId::seen, Role::Update, Tolerance::Exact),
        (BufferId::blocks, Role::Output, Tolerance::Exact),
        (BufferId::spheres, Role::Output, Tolerance::Fields(SPHERE)),
    ],
    reason: "places and blocks are decided exactly; a sphere is a few roundings of the extent",
    sizes: &[(BufferId::seen, Size::Elements(State::pixels))],
    granularity: Granularity::Object,
    carriers: &[Carrier::Blocks],
    needs: &[Need::Light, Need::Picture],
    serves: Serves { object: |object, _| object.by_pixel, none: "the receivers are triangles" },
    runs: Update::view,
    ..super::stage(cpu, gpu)
};

pub use crate::layout::TILE_BLOCKS as LAYERS;

/// Receivers in a tile.
const RECEIVERS: u32 = BLOCK_RECEIVERS as u32;
const _: () = assert!(RECEIVERS == TILE_SIDE * TILE_SIDE);

/// Number of tiles in a picture of this size.
#[must_use]
pub fn tiles([width, height]: [u32; 2]) -> u32 {
    width.div_ceil(TILE_SIDE) * height.div_ceil(TILE_SIDE)
}

/// The pixel at position `k` of a tile, if it lies in the picture.
fn pixel(camera: &Camera, tile: u32, k: u32) -> Option<usize> {
    let across = camera.width.div_ceil(TILE_SIDE);
    let (column, row) = (tile % across * TILE_SIDE + k % TILE_SIDE, tile / across * TILE_SIDE + k / TILE_SIDE);
    (column < camera.width && row < camera.height).then(|| (row * camera.width + column) as usize)
}

/// The point that a pixel shows, interpolated between its triangle's corners; in `f32`, since rays start there.
pub(super) fn place(hit: &Hit, [a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let first = 1.0 - hit.u - hit.v;
    std::array::from_fn(|axis| first * a[axis] + hit.u * b[axis] + hit.v * c[axis])
}

/// A tile's points with their pixels, block by block; `torn` if a point is near no block.
#[derive(Default)]
struct Tile {
    layers: [Vec<(usize, [f32; 3])>; TILE_BLOCKS as usize],
    torn: bool,
}

impl Tile {
    /// Adds a point to the first block that it is near; decisions in `f32`.
    fn put(&mut self, camera: &Camera, pixel: usize, place: [f32; 3], depth: f32) {
        let square = |v: [f32; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let width = camera.width as f32;
        let widest = TILE_REACH * (square(camera.right) * (depth * depth));
        let near = |layer: &Vec<(usize, [f32; 3])>| {
            layer.first().is_none_or(|(_, seed)| {
                let offset = [place[0] - seed[0], place[1] - seed[1], place[2] - seed[2]];
                square(offset) * (width * width) <= widest
            })
        };
        let layer = self.layers.iter().position(near);
        self.torn |= layer.is_none();
        self.layers[layer.unwrap_or(TILE_BLOCKS as usize - 1)].push((pixel, place));
    }
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let (params, camera) = (&data.object_params[0], &data.camera[0]);
    let tile = |number: u32| {
        let mut tile = Tile::default();
        for pixel in (0..RECEIVERS).filter_map(|k| pixel(camera, number, k)) {
            let hit = data.hits[pixel];
            let face = hit.face.wrapping_sub(params.first_face);
            let Some(corners) = data.triangles.get(face as usize) else { continue };
            let place = place(&hit, corners.map(|v| data.positions[v as usize]));
            tile.put(camera, pixel, place, hit.depth);
        }
        tile
    };
    let tiles: Vec<Tile> = (0..params.blocks / TILE_BLOCKS).into_par_iter().map(tile).collect();

    let disc = disc(f64::from(data.clusters[0].area), params.usual_blocks);
    let (mut places, mut seen) = (vec![[NOWHERE; 3]; RECEIVERS as usize * tiles.len()], data.seen.clone());
    let (mut blocks, mut spheres) = (Vec::new(), Vec::new());
    for (number, tile) in tiles.iter().enumerate() {
        let mut first = RECEIVERS * number as u32;
        for (k, layer) in (1..).zip(&tile.layers) {
            let block = Block { node: 0, first, count: layer.len() as u32 };
            for &(pixel, place) in layer {
                (places[first as usize], seen[pixel]) = (place, first);
                first += 1;
            }
            let mut round = Sphere { center: [NOWHERE; 3], ..Sphere::default() };
            if block.count > 0 {
                round = sphere(&block, disc, |place| wide(places[place]));
            }
            if tile.torn && k == TILE_BLOCKS {
                round.relative_moment = UNBOUNDED_SPREAD;
            }
            blocks.push(block);
            spheres.push(round);
        }
    }
    (state.data.receiver_positions, state.data.seen, state.data.blocks, state.data.spheres) =
        (places, seen, blocks, spheres);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.blocks / TILE_BLOCKS as usize)
}

#[cfg(test)]
mod tests {
    use crate::view::pixel_receivers::*;

    #[test]
    fn every_pixel_is_in_one_tile() {
        let camera = Camera { width: 10, height: 7, ..Camera::default() };
        let mut seen = [0; 70];
        for place in 0..RECEIVERS * tiles([10, 7]) {
            if let Some(pixel) = pixel(&camera, place / RECEIVERS, place % RECEIVERS) {
                seen[pixel] += 1;
            }
        }
        assert!(seen.iter().all(|&count| count == 1));
    }

    #[test]
    fn what_is_far_apart_is_parted() {
        // Ten pixels, 90 degrees: at depth 1 a pixel is 0.2 wide; half of that is 0.1, and 32 times that is 3.2.
        let camera = Camera { width: 10, right: [1.0, 0.0, 0.0], ..Camera::default() };
        let mut tile = Tile::default();
        for (pixel, z) in [0.0, -3.0, 10.0, 9.0, 20.0, 30.0].into_iter().enumerate() {
            tile.put(&camera, pixel, [0.0, 0.0, z], 1.0);
        }
        let pixels = tile.layers.each_ref().map(|layer| layer.iter().map(|&(pixel, _)| pixel).collect::<Vec<_>>());
        assert_eq!(pixels, [vec![0, 1], vec![2, 3], vec![4], vec![5]]);
        assert!(!tile.torn);
        tile.put(&camera, 6, [0.0, 0.0, 40.0], 1.0);
        assert!(tile.torn && tile.layers[3].len() == 2);
    }
}
