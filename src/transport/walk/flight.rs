//! Flights of a photon, to a collision or to the surface, in step with
//! `glsl/transport/walk/random_walk/fly.comp`.

use std::sync::atomic::{AtomicU64, Ordering};

use super::clearance::around;
use super::exact::{about, inverse, kept_unit, minus_log, outside, passes, random4, unit_random};
use super::hit::{Meeting, meeting};
use super::start::normal;
use super::{sum64, words64};
use crate::geometry::trace::dot;
use crate::layout::{
    Buffers, ExitSum, NONE, Photon, WALK_FLIGHTS, WALK_FREE, WALK_LIGHT, WALK_SQUARE_BITS, WalkBalance,
};

/// Weights that left through a triangle: for each channel after one collision, after more, and the sum of squares.
#[derive(Default)]
pub(super) struct Exit([[AtomicU64; 3]; 3]);

impl Exit {
    /// From a buffer's record.
    pub fn of(sum: &ExitSum) -> Self {
        let square = |c: usize| sum64([sum.square[c], sum.square_high[c]]);
        Self([0, 1, 2].map(|c| [sum.once(c), sum.more(c), square(c)].map(AtomicU64::new)))
    }

    /// As a buffer's record.
    pub fn sum(&self) -> ExitSum {
        let word = |kind: usize, high: usize| [0, 1, 2].map(|c| words64(self.0[c][kind].load(Ordering::Relaxed))[high]);
        ExitSum {
            once: word(0, 0),
            once_high: word(0, 1),
            more: word(1, 0),
            more_high: word(1, 1),
            square: word(2, 0),
            square_high: word(2, 1),
        }
    }

    fn leave(&self, channel: usize, weight: u32, once: bool) {
        let root = u64::from(weight >> WALK_SQUARE_BITS);
        self.0[channel][2].fetch_add(root * root, Ordering::Relaxed);
        self.0[channel][usize::from(!once)].fetch_add(weight.into(), Ordering::Relaxed);
    }
}

fn add(sum: &mut [u32; 2], more: u32) {
    *sum = words64(sum64(*sum) + u64::from(more));
}

/// The direction after a collision, drawn by Henyey and Greenstein's phase function with this mean cosine.
pub(super) fn scattered(way: [f32; 3], forward: f32, random: [u32; 2]) -> [f32; 3] {
    let u = unit_random(random[0]);
    let cosine = if forward == 0.0 {
        2.0 * u - 1.0
    } else {
        let g2 = forward * forward;
        let part = (1.0 - g2) * inverse(1.0 - forward + 2.0 * forward * u);
        let leaning = (1.0 + g2 - part * part) * (0.5 * inverse(forward.abs().max(1e-6)));
        (if forward < 0.0 { -leaning } else { leaning }).clamp(-1.0, 1.0)
    };
    kept_unit(about(way, cosine, unit_random(random[1])))
}

/// A collision at the end of a flight.
fn collide(data: &Buffers, channel: usize, photon: &mut Photon, balance: &mut WalkBalance, (path, random): Drawn) {
    let params = &data.walk_params[0];
    photon.place = std::array::from_fn(|k| photon.place[k] + path * photon.way[k]);
    let absorbed = ((u64::from(photon.weight) * u64::from(params.absorbed[channel])) >> 32) as u32;
    photon.weight -= absorbed;
    add(&mut balance.absorbed, absorbed);
    if photon.weight < WALK_LIGHT {
        let dies = random[1] >> 31 != 0;
        add(if dies { &mut balance.killed } else { &mut balance.gained }, photon.weight);
        photon.weight = if dies { 0 } else { 2 * photon.weight };
    }
    photon.way = scattered(photon.way, params.forward[channel], [random[2], random[3]]);
    photon.collisions = (photon.collisions + 1).min(2);
    photon.face = NONE;
}

/// A flight's length and random numbers.
type Drawn = (f32, [u32; 4]);

/// The next flight.
fn drawn(data: &Buffers, channel: usize, photon: &mut Photon) -> Drawn {
    let params = &data.walk_params[0];
    photon.flights += 1;
    let random = random4(photon.number, photon.flights, channel as u32, params.seed);
    (minus_log(unit_random(random[0])) * params.free_path[channel], random)
}

/// A few flights of a photon that is under way: free ones, to a collision far from the surface; then one that may meet
/// the surface.
pub(super) fn fly(data: &Buffers, channel: usize, photon: &mut Photon, balance: &mut WalkBalance, exits: &[Exit]) {
    let mut flight = drawn(data, channel, photon);
    for _ in 0..WALK_FREE {
        if flight.0 >= around(data, photon.place) {
            break;
        }
        collide(data, channel, photon, balance, flight);
        if photon.weight == 0 {
            return;
        }
        flight = drawn(data, channel, photon);
    }
    match meeting(data, photon.place, photon.way, flight.0, photon.face) {
        Meeting::Free => collide(data, channel, photon, balance, flight),
        Meeting::Lost => {
            add(&mut balance.lost, photon.weight);
            photon.weight = 0;
        }
        Meeting::At(face, weights) => {
            let corners = data.triangles[face].map(|v| data.positions[v as usize]);
            let w = weights.map(f32::abs);
            let by = inverse(w[0] + w[1] + w[2]);
            let share = w.map(|w| w * by);
            photon.place =
                std::array::from_fn(|k| share[0] * corners[0][k] + share[1] * corners[1][k] + share[2] * corners[2][k]);
            let normal = normal(corners);
            let (eta, inner) = (data.object_params[0].eta[channel], dot(photon.way, normal).clamp(0.0, 1.0));
            if unit_random(flight.1[1]) < passes(eta, outside(eta, inner), inner) {
                match photon.collisions {
                    0 => add(&mut balance.straight, photon.weight),
                    collisions => exits[face].leave(channel, photon.weight, collisions == 1),
                }
                photon.weight = 0;
            } else {
                photon.way = kept_unit(std::array::from_fn(|k| photon.way[k] - 2.0 * inner * normal[k]));
                photon.face = face as u32;
            }
        }
    }
    if photon.weight != 0 && photon.flights >= WALK_FLIGHTS {
        add(&mut balance.lost, photon.weight);
        photon.weight = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_paths_and_directions_have_their_moments() {
        let count = 400_000u32;
        let random = |k: u32| random4(k, 3, 1, 9);
        let mean = |f: &dyn Fn([u32; 4]) -> f64| (0..count).map(|k| f(random(k))).sum::<f64>() / f64::from(count);
        // Of an exponential distribution, the n-th moment is n!.
        for (n, factorial) in [(1, 1.0), (2, 2.0), (3, 6.0)] {
            let moment = mean(&|r| f64::from(minus_log(unit_random(r[0]))).powi(n));
            assert!((moment / factorial - 1.0).abs() < 0.01 * f64::from(n * n), "{n}: {moment}");
        }
        // Of Henyey and Greenstein's phase function, the means of Legendre polynomials are powers of g.
        let axis = about([0.0, 0.0, 1.0], 0.3, 0.2);
        for g in [0.0f32, 0.3, 0.9, -0.7] {
            let cosine = |r: [u32; 4]| f64::from(dot(axis, scattered(axis, g, [r[2], r[3]])));
            let (one, two) = (mean(&cosine), mean(&|r| 1.5 * cosine(r).powi(2) - 0.5));
            let wide = f64::from(g);
            assert!((one - wide).abs() < 0.004 && (two - wide * wide).abs() < 0.004, "{g}: {one} {two}");
        }
        // All around: the mean direction is along the axis.
        let way = [0, 1, 2].map(|k| mean(&|r| f64::from(scattered(axis, 0.5, [r[2], r[3]])[k])));
        assert!((0..3).all(|k| (way[k] - 0.5 * f64::from(axis[k])).abs() < 0.004), "{way:?}");
    }
}
