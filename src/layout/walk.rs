//! The structs of the random walk, shared by host and device. Sums of weights have 64 bits: a word and a high word.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { walk_records:
    /// How light walks through an object, padded so that it can be bound by itself.
    WalkParams {
        /// Mean distance between collisions, per channel, length; above 0.
        free_path: [f32; 3],
        /// Mean cosine of scattering, per channel, -0.95 to 0.95.
        forward: [f32; 3],
        /// Share of its weight that a photon loses at a collision, per channel, times 2^32.
        absorbed: [u32; 3],
        /// Photons that start, of each channel.
        photons: u32,
        /// Photons under way at once, a multiple of 3: a third of each channel.
        slots: u32,
        /// Seed of the photons' random numbers.
        seed: u32,
        /// Unused.
        padding: [u32; 32],
        /// Unused.
        more_padding: [u32; 16],
        /// Unused.
        last_padding: [u32; 3],
        /// Unused.
        end_padding: u32,
    }
    /// A photon under way.
    Photon {
        /// Where it is.
        place: [f32; 3],
        /// The unit direction in which it flies.
        way: [f32; 3],
        /// The light that it carries, `WALK_WEIGHT` when it starts; 0 if there is none under way.
        weight: u32,
        /// The triangle of the object that it comes from, `NONE` after a collision.
        face: u32,
        /// Its number among those of its channel.
        number: u32,
        /// Flights so far, to a collision or to the surface.
        flights: u32,
        /// Collisions so far; from 2 on they are not counted.
        collisions: u32,
        /// Photons that this slot has started.
        started: u32,
    }
    /// Where the weight of a slot's photons has gone, but for what has left. What entered and was gained is what left,
    /// passed straight, was absorbed, lost or given up, and is under way.
    WalkBalance {
        /// Weight of the photons that started.
        entered: [u32; 2],
        /// Left without a collision.
        straight: [u32; 2],
        /// Lost in collisions.
        absorbed: [u32; 2],
        /// Of photons that found no way out: the surface is open, or crosses itself.
        lost: [u32; 2],
        /// Given up by roulette.
        killed: [u32; 2],
        /// Won by roulette.
        gained: [u32; 2],
    }
    /// Weights that left through a triangle, per channel.
    ExitSum {
        /// Of photons that collided once.
        once: [u32; 3],
        /// Its high words.
        once_high: [u32; 3],
        /// Of those that collided more often.
        more: [u32; 3],
        /// Its high words.
        more_high: [u32; 3],
        /// Squares of all these weights, each without its low `WALK_SQUARE_BITS` bits.
        square: [u32; 3],
        /// Its high words.
        square_high: [u32; 3],
    }
    /// The light that enters the triangles up to this one, in integers, per channel.
    EntrySum {
        /// The sum.
        low: [u32; 3],
        /// Its high words.
        high: [u32; 3],
    }
    /// The same of a block of `ENTRY_BLOCK` triangles: of those before it. One element more has the sum of all.
    EntryBlock {
        /// The sum.
        low: [u32; 3],
        /// Its high words.
        high: [u32; 3],
        /// The largest light of a triangle, as the bits of a float.
        most: [u32; 3],
    }
}
