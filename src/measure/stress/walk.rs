//! Random walks through extreme media and shapes: values are sound, every unit of light is accounted for, and a device
//! counts what the CPU counts.

use super::meshes::{both, reversed};
use super::shade::cone;
use super::solve::scene;
use super::{Bound, Case, Found, Kind, Plant, Worst, ZERO, within};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::{BufferId, ExitSum, WALK_WEIGHT, WalkBalance};
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::{Mesh, Scene};
use crate::session::run::Session;
use crate::transport::walk::sum64;

/// Photons of each channel.
const PHOTONS: u64 = 300;

/// The bound on radiosity.
const SAME: Bound = within(1e-6, 1e-5);
const REASON: &str = "tallies are the same integers on the CPU and on every device; a few roundings make radiosity of them. In \
                      the place of brute force: light that does not add up, in integers";

const fn case(name: &'static str, fallback: &'static str, make: fn() -> Result<Scene>) -> Case {
    Case { name, fallback, bound: SAME, brute: ZERO, reason: REASON, kind: Kind::Walk(make) }
}

/// The base scene with these settings, walked through.
fn walked(sets: &[&str]) -> Result<Scene> {
    let photons = format!("transport.walks={PHOTONS}");
    scene(&[sets, &[&photons]].concat())
}

/// The same with another closed mesh.
fn shaped(mesh: Mesh, sets: &[&str]) -> Result<Scene> {
    let mut scene = walked(sets)?;
    scene.objects[0].mesh = Mesh { open_edges: 0, ..mesh };
    Ok(scene)
}

/// A ball with a hollow of half its size.
fn hollow() -> Result<Mesh> {
    let outer = scene(&["object.0.detail=2"])?.objects.swap_remove(0).mesh;
    let mut inner = reversed(outer.clone());
    inner.positions.iter_mut().for_each(|place| *place *= 0.5);
    Ok(both(outer, inner))
}

/// The cases.
pub(super) const CASES: &[Case] = &[
    case("walk: alpha' 0 and 1", "what is absorbed leaves a unit of 2^30; what is not leaves whole", || {
        walked(&["object.0.material.sigma_s_prime=[0, 22, 5]", "object.0.material.sigma_a=[22, 0, 0]"])
    }),
    case("walk: eta 1, 2.5 and 0.6", "at 1 nothing refracts, exactly", || {
        walked(&["object.0.material.eta=[1, 2.5, 0.6]"])
    }),
    case("walk: mean free path 1e-4 of the object", "none", || {
        walked(&["object.0.material.sigma_s_prime=[1e4, 5e3, 9e3]", "object.0.material.sigma_a=[10, 100, 1e3]"])
    }),
    case(
        "walk: mean free path 1e4 of the object",
        "nearly all light passes straight through; the other channels have 10 and 1",
        || walked(&["object.0.material.sigma_s_prime=[1e-4, 0.1, 1]", "object.0.material.sigma_a=[0, 1e-6, 5e-5]"]),
    ),
    case("walk: forward and backward scattering", "none", || walked(&["object.0.material.g=[0.95, -0.95, 1e-6]"])),
    case("walk: needle", "rounding may put a photon outside: it comes back in", || {
        shaped(cone(6, 1e-3, 0.49), &["object.0.material.sigma_s_prime=[22, 2, 900]"])
    }),
    case("walk: cavity", "light that leaves into it is gone", || shaped(hollow()?, &[])),
    case("walk: light in a cavity", "the inner wall alone is lit", || {
        // Files may not have a light within the medium, which the ball without its hollow would be.
        let lamp = "light=[{ type = 'point', position = [0, 0, 0], intensity = 1 }]";
        let mut scene = shaped(hollow()?, &[lamp, "object.0.material.two_sided=true"])?;
        scene.objects[0].material.two_sided = false;
        Ok(scene)
    }),
    case("walk: grazing light", "as any: little light enters", || {
        walked(&["object.0.shape=slab", "object.0.detail=10", "light.0.direction=[1, 0, 1e-4]"])
    }),
];

/// A walk's tallies and its radiosity.
fn walk(scene: &Scene, device: Option<&Device>) -> Result<Session> {
    let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    session.fetch(&[BufferId::exits, BufferId::balances, BufferId::radiosity, BufferId::walk_noise])?;
    Ok(session)
}

/// Units of light that entered or were gained, and that went, of a channel.
fn accounts(exits: &[ExitSum], balances: &[WalkBalance], channel: usize) -> [u64; 3] {
    let sum = |of: fn(&WalkBalance) -> [u32; 2]| {
        balances.iter().skip(channel).step_by(3).map(|balance| sum64(of(balance))).sum::<u64>()
    };
    let left: u64 = exits.iter().map(|exit| exit.once(channel) + exit.more(channel)).sum();
    let went = left + sum(|b| b.straight) + sum(|b| b.absorbed) + sum(|b| b.lost) + sum(|b| b.killed);
    [sum(|b| b.entered), sum(|b| b.entered) + sum(|b| b.gained), went]
}

/// The walk against the CPU's, and what does not add up.
pub(super) fn run(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    let (expected, found) = (walk(scene, None)?, walk(scene, device)?);
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
    let numbers = || own.radiosity.iter().flatten().zip(radiosity.iter().flatten());
    let square = |of: &dyn Fn(f64, f64) -> f64| numbers().map(|(a, b)| of(f64::from(*a), f64::from(*b))).sum::<f64>();
    let (whole, apart) = (square(&|a, _| a * a), square(&|a, b| (a - b).powi(2)));
    let most = numbers().map(|(a, b)| f64::from(a - b).abs()).fold(0.0, f64::max);
    let mean = (whole / numbers().count().max(1) as f64).sqrt();
    if whole == 0.0 {
        usual.faults.push("no light leaves at all".into());
    }
    usual.error = Worst { l2: (apart / whole).sqrt(), max: most / mean };
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
        let session = walk(&walked(&["object.0.detail=1"]).unwrap(), None).unwrap();
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
