//! Random walks through extreme media and shapes: values are sound, every unit of light is accounted for, and a device
//! counts what the CPU counts.

use super::setup::Setup;
use super::{Found, Plant, Worst};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::{BufferId, ExitSum, WALK_WEIGHT, WalkBalance};
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::run::Session;
use crate::transport::walk::sum64;

/// Photons of each channel.
const PHOTONS: u64 = 300;

/// A walk's tallies and its radiosity.
fn walk(scene: &Scene, device: Option<&Device>) -> Result<Session> {
    let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    session.fetch(&[BufferId::exits, BufferId::balances, BufferId::radiosity, BufferId::walk_noise])?;
    Ok(session)
}

/// Units of light of a channel: those that entered, those that entered or were gained, and those that went.
fn accounts(exits: &[ExitSum], balances: &[WalkBalance], channel: usize) -> [u64; 3] {
    let sum = |count: fn(&WalkBalance) -> [u32; 2]| {
        balances.iter().skip(channel).step_by(3).map(|balance| sum64(count(balance))).sum::<u64>()
    };
    let left: u64 = exits.iter().map(|exit| exit.once(channel) + exit.more(channel)).sum();
    let went = left + sum(|b| b.straight) + sum(|b| b.absorbed) + sum(|b| b.lost) + sum(|b| b.killed);
    [sum(|b| b.entered), sum(|b| b.entered) + sum(|b| b.gained), went]
}

/// The walk against the CPU's, and its balance.
pub(super) fn run(setup: &Setup, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    let scene = setup.scene(&[format!("transport.walks={PHOTONS}")])?;
    let (expected, found) = (walk(&scene, None)?, walk(&scene, device)?);
    let (own, data) = (&expected.state().data, &found.state().data);
    let mut radiosity = data.radiosity.clone();
    if let Some(plant) = plant {
        plant.apply(&mut radiosity);
    }
    let (mut usual, mut added) = (Found::default(), Found::default());
    usual.look("radiosity", &radiosity);
    usual.look("standard errors", &data.walk_noise);
    if own.exits != data.exits || own.balances != data.balances {
        usual.faults.push("the tallies are not the CPU's, bit for bit".into());
    }
    if own.radiosity.iter().flatten().all(|&x| x == 0.0) {
        usual.faults.push("no light leaves at all".into());
    }
    let pairs = own.radiosity.iter().flatten().copied().zip(radiosity.iter().flatten().copied());
    usual.error = Worst::of(pairs, 3 * radiosity.len());
    for channel in 0..3 {
        let [entered, given, went] = accounts(&data.exits, &data.balances, channel);
        if entered != PHOTONS * u64::from(WALK_WEIGHT) {
            added.faults.push(format!("channel {channel}: {entered} units of light entered by {PHOTONS} photons"));
        }
        let share = given.abs_diff(went) as f64 / given.max(1) as f64;
        added.error = Worst { l2: share.max(added.error.l2), max: share.max(added.error.max) };
    }
    Ok([usual, added])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_is_missing_is_missed() {
        let sets = ["object.0.detail=1".to_string(), format!("transport.walks={PHOTONS}")];
        let session = walk(&Setup::default().scene(&sets).unwrap(), None).unwrap();
        let data = &session.state().data;
        let [entered, given, went] = accounts(&data.exits, &data.balances, 1);
        assert!(given == went && entered == PHOTONS << 30 && entered <= given);
        let (mut balances, mut exits) = (data.balances.clone(), data.exits.clone());
        balances[4].absorbed[0] ^= 1;
        assert_ne!(accounts(&exits, &balances, 1)[1], accounts(&exits, &balances, 1)[2]);
        exits[7].more_high[1] += 1;
        assert_ne!(accounts(&exits, &data.balances, 1)[2], went);
    }
}
