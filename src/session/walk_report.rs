//! What became of the light of a walk: shares, noise, and whether it adds up.

use crate::error::{Error, Input, Result};
use crate::layout::{WALK_WEIGHT, WalkBalance};
use crate::state::State;
use crate::transport::walk::sum64;

/// Share of the light that may find no way out, by rounding.
const LOST: f64 = 1e-4;
/// Photons that may be lost however few there are.
const FEW_LOST: u64 = 8;

/// What became of the light in a walk through an object, per channel; shares are of what entered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WalkReport {
    /// The object.
    pub object: usize,
    /// Photons of each channel.
    pub photons: u32,
    /// Time of the walk, seconds.
    pub seconds: f64,
    /// Estimated relative error of the radiosity's means over patches, L2.
    pub noise: [f64; 3],
    /// Share that left after a collision.
    pub left: [f64; 3],
    /// Share that left without one: it is not in the radiosity.
    pub straight: [f64; 3],
    /// Share that was absorbed.
    pub absorbed: [f64; 3],
    /// Share that found no way out.
    pub lost: [f64; 3],
    /// Whether it was stopped before it was as exact as asked.
    pub stopped: bool,
}

/// Sum of a field of the balances over the slots of a channel.
fn sum(state: &State, channel: usize, field: fn(&WalkBalance) -> [u32; 2]) -> u64 {
    state.data.balances.iter().skip(channel).step_by(3).map(|balance| sum64(field(balance))).sum()
}

/// What became of the light so far; an error where it does not add up, or too much of it finds no way out.
pub(super) fn report_of(state: &State, object: usize, parts: &[std::ops::Range<usize>]) -> Result<WalkReport> {
    let (part, data) = (&state.objects[object], &state.data);
    let exits = &data.exits[part.first.faces..][..part.count.faces];
    let photons = data.walk_params[object].photons;
    let mut report = WalkReport { object, photons, ..WalkReport::default() };
    for c in 0..3 {
        let total = |field: fn(&WalkBalance) -> [u32; 2]| sum(state, c, field);
        let left: u64 = exits.iter().map(|exit| exit.once(c) + exit.more(c)).sum();
        let (entered, gained, killed) = (total(|b| b.entered), total(|b| b.gained), total(|b| b.killed));
        let (straight, absorbed, lost) = (total(|b| b.straight), total(|b| b.absorbed), total(|b| b.lost));
        if entered + gained != left + straight + absorbed + lost + killed {
            let what = format!("{entered} + {gained} in, {left} + {straight} + {absorbed} + {lost} + {killed} out");
            return Err(Error::device("adding up the light of a walk", what));
        }
        let share = |weight: u64| if entered > 0 { weight as f64 / entered as f64 } else { 0.0 };
        (report.left[c], report.straight[c]) = (share(left), share(straight));
        (report.absorbed[c], report.lost[c]) = (share(absorbed), share(lost));
        if lost > FEW_LOST * u64::from(WALK_WEIGHT) && report.lost[c] > LOST {
            let photons = lost.div_ceil(WALK_WEIGHT.into());
            let found = format!("{photons} photons, {:.2e} of the light, that found no way out", report.lost[c]);
            let fault = Input::new("the surface has holes or crosses itself").key(format!("object.{object}"));
            return Err(fault.found(found).expected("a closed mesh that does not cross itself").into());
        }
        let (mut noise, mut square) = (0.0, 0.0);
        for faces in parts {
            let area =
                |face: usize| data.clusters[part.first.nodes + data.leaves[part.first.faces + face] as usize].area;
            let area: f64 = faces.clone().map(|face| f64::from(area(face))).sum();
            let [left, squares] = exits[faces.clone()]
                .iter()
                .map(|exit| exit.moments(c))
                .fold([0.0; 2], |[left, squares], [one, two]| [left + one, squares + two]);
            let variance = (squares - left * left / f64::from(photons.max(1))).max(0.0);
            if area > 0.0 {
                noise += variance / area;
                square += (left * left - variance).max(0.0) / area;
            }
        }
        report.noise[c] = if square > 0.0 {
            (noise / square).sqrt()
        } else if noise > 0.0 {
            1.0
        } else {
            0.0
        };
    }
    Ok(report)
}
