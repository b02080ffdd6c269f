//! A random walk of light through an object, without approximations: photons enter by the light on each triangle,
//! refracted, fly, collide and scatter, lose weight, are reflected from within by Fresnel's formulas, and leave.
//!
//! Random numbers come from a hash of photon and flight, weights are integers, sums of weights have 64 bits, and all
//! arithmetic that decides anything is `f32` additions, multiplications and comparisons. So the CPU and every device
//! count the same bits, in however many steps and with however many photons at once: each photon's walk depends only
//! on its number, and sums of integers do not depend on their order.

pub mod clearance;
pub mod entry_sums;
pub mod exact;
pub mod exit_radiosity;
mod flight;
pub(super) mod hit;
pub mod random_walk;
pub(super) mod start;

use crate::layout::{Buffers, ENTRY_BLOCK, EntryBlock, EntrySum, ExitSum, WALK_SQUARE_BITS, WALK_WEIGHT};
use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Stage};

/// Defaults of a stage of the random walk.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage { module: "transport/walk", carriers: &[Carrier::Walk], ..super::stage(cpu, gpu) }
}

/// A sum of 64 bits from its words.
#[must_use]
pub fn sum64([low, high]: [u32; 2]) -> u64 {
    (u64::from(high) << 32) | u64::from(low)
}

/// The words of a sum of 64 bits.
#[must_use]
pub fn words64(sum: u64) -> [u32; 2] {
    [sum as u32, (sum >> 32) as u32]
}

/// Number of blocks of triangles whose light is summed together.
#[must_use]
pub fn blocks(faces: usize) -> usize {
    faces.div_ceil(ENTRY_BLOCK as usize)
}

/// The power of two that makes the largest light of a triangle, given as bits, 2^30 to 2^31.
#[must_use]
pub fn factor(most: u32) -> f32 {
    f32::from_bits((284 - (most >> 23).clamp(31, 254)) << 23)
}

impl EntryBlock {
    /// The light of all blocks before this one in one channel, as an integer.
    #[must_use]
    pub fn sum(&self, channel: usize) -> u64 {
        sum64([self.low[channel], self.high[channel]])
    }

    /// All light that enters in one channel, area times irradiance, if this is the entry after the last block's.
    #[must_use]
    pub fn light(&self, channel: usize) -> f64 {
        self.sum(channel) as f64 / f64::from(factor(self.most[channel]))
    }
}

impl EntrySum {
    /// The light of all triangles up to and including this one in one channel, as an integer.
    #[must_use]
    pub fn sum(&self, channel: usize) -> u64 {
        sum64([self.low[channel], self.high[channel]])
    }
}

impl ExitSum {
    /// Weight of photons that left after one collision.
    #[must_use]
    pub fn once(&self, channel: usize) -> u64 {
        sum64([self.once[channel], self.once_high[channel]])
    }

    /// Weight of photons that left after several collisions.
    #[must_use]
    pub fn more(&self, channel: usize) -> u64 {
        sum64([self.more[channel], self.more_high[channel]])
    }

    /// The sum of the weights that left, and that of their squares, in units of full weight.
    #[must_use]
    pub fn moments(&self, channel: usize) -> [f64; 2] {
        let whole = f64::from(WALK_WEIGHT);
        let unit = whole / f64::from(1u32 << WALK_SQUARE_BITS);
        let squares = sum64([self.square[channel], self.square_high[channel]]) as f64;
        [(self.once(channel) + self.more(channel)) as f64 / whole, squares / (unit * unit)]
    }
}

/// All light that entered an object, from its sums.
#[must_use]
pub fn total(data: &Buffers) -> EntryBlock {
    data.entry_blocks.get(blocks(data.object_params[0].faces as usize)).copied().unwrap_or_default()
}
