//! Stage `acceptance_radii`: turns the oracle into distances. Every error law falls with distance, so each threshold
//! becomes one distance per node, and the walk only adds, multiplies and compares.
//!
//! A law `factor W tau^n sum_j z_j p(s_j) (q2 / (2 s_j^2))^n` separates into the node's strength `W tau^n` and a
//! function of distance alone, the same for all nodes. The inverse of that function is tabulated once per frame; a
//! node only looks it up.
//!
//! Where lists have to serve any light of the same contrast (mode `render`), W is the node's area, and tau the second
//! moment of that area about its centroid.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::dipole::derivatives::GroupProfile;
use crate::dipole::form_factor::ladder::{chi_distance, q2};
use crate::error::Result;
use crate::layout::{
    AREA_CHI, BLOCK_CLASSES, BufferId, Buffers, DROPPED_SHARE, ERROR_LAWS, EXPANDED_SHARE, Emitter, FARTHEST, LAW_AREA,
    LAW_EXPANSION, LAW_MAGNITUDE, LAW_MOMENTS, LAW_SAMPLE, ObjectParams, RANGE_DEPTH, RANGE_ENTRIES, SAMPLE_CHI,
};
use crate::state::{Carrier, Field, Pass, Role, Scope, Size, Stage, State, Tolerance, Update, wide};
use crate::transport::diffusion::layer_gain;

/// Tolerances: the rounding of a logarithm, 60 x 2^-24, moves the argument by that share of the table's depth.
const EMITTER: &[Field] = &[
    Field { name: "place.3", relative: 5e-4, floor: 1e-6, of: "" },
    Field { name: "accept", relative: 5e-4, floor: 1e-6, of: "" },
    Field { name: "area", relative: 5e-4, floor: 1e-6, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "acceptance_radii",
    about: "the oracle as distances: beyond which a node is dropped, expanded, linked directly, or takes area points",
    equation: "factor W tau^n strength sum_j z_j p(s_j) (q2/(2 s_j^2))^n <= error x level, solved for the distance",
    writes: &[
        (BufferId::ranges, Role::Output, Tolerance::Float { relative: 1e-3, floor: 1e-6 }),
        (BufferId::emitters, Role::Output, Tolerance::Fields(EMITTER)),
        (BufferId::expansion_distances, Role::Output, Tolerance::Float { relative: 5e-4, floor: 1e-6 }),
    ],
    reason: "logarithms of up to 60 binary orders and a bisection: rounding moves the argument by up to 1e-5",
    sizes: &[(BufferId::ranges, Size::Elements(|_| ERROR_LAWS * (RANGE_ENTRIES + 2)))],
    carriers: &[Carrier::Blocks, Carrier::Diffusion],
    runs,
    ..super::stage(cpu, gpu)
};

fn runs(update: &Update) -> bool {
    match update.any_light {
        // Lists that are rebuilt anyway, for other pixels, are made for the current light.
        true => update.material() || update.change.relink || (update.other_receivers() && update.change.light),
        false => update.transport(),
    }
}

/// Square of the least distance in a layer's law, as a share of the triangles' mean area: the law would grow without
/// bound, as no source lies below the surface.
const LEAST: f64 = 1.0 / 64.0;

/// The binary logarithm of a law of diffusion at distance `u`: single layer over z_b, and double layer.
fn layer_law(params: &ObjectParams, least: f64, u: f64, power: f64) -> f64 {
    let channel = |c: usize| {
        let (k, z_b) = (f64::from(params.sigma[c]), f64::from(params.boundary[c]));
        let s2 = u * u + least;
        let (s, a) = (s2.sqrt(), k * s2.sqrt());
        (0.25 / PI * (1.0 / (z_b * s) + (1.0 + a) / s2)).log2() - a * std::f64::consts::LOG2_E
            + power * ((0.5 * q2(a)).log2() - s2.log2())
    };
    (0..3).map(channel).fold(-1e30, f64::max)
}

/// Exponent n and factor of each law, for this order of the moments.
fn laws(order: u32) -> ([f64; ERROR_LAWS], [f64; ERROR_LAWS]) {
    let cluster = 0.5 + 0.5 * f64::from(order);
    let (triangle, sample) = if order == 2 { (2.0, 1.5) } else { (1.0, 0.55) };
    ([0.0, cluster, 1.5, triangle, 3.0], [1.0, if order == 2 { 0.5 } else { 1.0 }, 0.5, sample, 0.045])
}

/// The binary logarithm of a law at distance `u`: the largest over the channels, each multiplied by its scale.
fn law(jets: &GroupProfile, scale: [f64; 3], u: f64, power: f64) -> f64 {
    let channel = |c: usize| {
        let dipole = jets.dipole(c);
        let source = |z: f64| {
            let s2 = u * u + z * z;
            let a = dipole.sigma * s2.sqrt();
            (z * (1.0 + a)).log2() - a * std::f64::consts::LOG2_E - 1.5 * s2.log2()
                + power * ((0.5 * q2(a)).log2() - s2.log2())
        };
        let [real, virt] = dipole.depths().map(source);
        let both = real.max(virt) + (1.0 + (real.min(virt) - real.max(virt)).exp2()).log2();
        both + dipole.strength.max(1e-37).log2() + scale[c].log2()
    };
    jets.channels().map(channel).fold(-1e30, f64::max)
}

/// One law's table: its logarithm at distance 0, how far that falls, and the distances of evenly spaced values.
fn table(law: impl Fn(f64) -> f64) -> Vec<f32> {
    let top = law(0.0);
    let depth = RANGE_DEPTH.min(top - law(FARTHEST));
    let solve = |entry: usize| {
        let wanted = top - depth * entry as f64 / (RANGE_ENTRIES - 1) as f64;
        let (mut low, mut high) = (0.0, std::f64::consts::SQRT_2);
        for _ in 0..30 {
            let middle: f64 = 0.5 * (low + high);
            if law(middle.powi(4)) <= wanted { high = middle } else { low = middle }
        }
        if entry == 0 { 0.0 } else { high.powi(4) as f32 }
    };
    [top as f32, depth as f32].into_iter().chain((0..RANGE_ENTRIES).map(solve)).collect()
}

/// The tables of all laws. `any_light`: lists have to serve any light; `solves`: the laws are those of diffusion.
fn tables(data: &Buffers, channels: u32, power: [f64; ERROR_LAWS], (any_light, solves): (bool, bool)) -> Vec<f32> {
    let params = &data.object_params[0];
    let jets = GroupProfile::new(params, channels);
    // The scale of the laws per channel: contrast / tint where lists serve any light, else 1 / reference level.
    let scale = [0, 1, 2].map(|c| {
        let tint = f64::from(params.tint[c]).max(1e-37);
        if any_light {
            f64::from(data.counters[0].contrast[c]) / tint
        } else {
            1.0 / f64::from(data.reference_level[0][c])
        }
    });
    let least = LEAST * f64::from(data.clusters[0].area) / f64::from(params.faces);
    let ranges = power.into_par_iter().flat_map(|power| match solves {
        true => table(|u| layer_law(params, least, u, power)),
        false => table(|u| law(&jets, scale, u, power)),
    });
    ranges.collect()
}

/// The distance from which on a law, times factor and strength (the latter as a binary logarithm), is as allowed.
fn distance(ranges: &[f32], law: usize, strength: f64, factor: f64, allowed: f64) -> f64 {
    let table = &ranges[law * (RANGE_ENTRIES + 2)..];
    let (top, depth) = (f64::from(table[0]), f64::from(table[1]));
    let at = (top - (allowed.log2() - strength - factor.log2())) / depth.max(1e-6) * (RANGE_ENTRIES - 1) as f64;
    if at <= 0.0 || at.is_nan() {
        return 0.0;
    }
    if at >= (RANGE_ENTRIES - 1) as f64 {
        return FARTHEST;
    }
    let entry = at as usize;
    let (low, high) = (f64::from(table[2 + entry]), f64::from(table[3 + entry]));
    low + (high - low) * (at - entry as f64)
}

/// The centre, strength, second moment and radius of a node: of its light, or of its area where lists have to serve any
/// light.
fn source(data: &Buffers, base: usize, node: usize, any_light: bool) -> ([f32; 3], f32, f64, f64) {
    if any_light {
        let cluster = &data.clusters[node];
        let [low, high, center] = [data.bounds[node].low, data.bounds[node].high, cluster.center].map(wide);
        let radius = (center - low).max(high - center).length();
        return (cluster.center, cluster.area, f64::from(cluster.moment_trace), radius);
    }
    let (m, s) = (&data.moments[base + node], &data.second_moments[base + node]);
    (m.center, m.weight, s.diagonal.iter().copied().map(f64::from).sum::<f64>(), f64::from(s.radius))
}

fn cpu(state: &mut State, at: Scope) {
    let (base, _) = state.part(BufferId::moments, at);
    let (group, any_light) = (state.object(at).groups[at.group], state.any_light(at));
    let (order, solves) = (state.moment_order(at), state.object(at).solves());
    let data = &mut state.data;
    let params = data.object_params[0];
    let (power, factor) = laws(order);
    data.ranges = tables(data, group.channels, power, (any_light, solves));

    let range = |law: usize, strength: f64, allowed: f64| distance(&data.ranges, law, strength, factor[law], allowed);
    let gain = if solves { layer_gain(&params, f64::from(data.clusters[0].area)) } else { 1.0 };
    let error = gain * f64::from(params.link_error);
    let disc = f64::from(data.clusters[0].area) / (std::f64::consts::TAU * f64::from(params.usual_blocks));
    let sigma = params.sigma.map(f64::from);
    let nearest = params.z_real.iter().copied().map(f64::from).fold(f64::INFINITY, f64::min);
    let nearest = if solves { 0.0 } else { nearest };
    let emitter = |node: usize| {
        let skip = data.topology[node].skip;
        let (center, strength, trace, radius) = source(data, base, node, any_light);
        let [x, y, z] = center;
        let right = if skip as usize == node + 1 { 0 } else { data.topology[node + 1].skip };
        let mut emitter = Emitter { place: [x, y, z, -1e9], accept: 0.0, area: 0.0, skip, right };
        let mut expands = [0.0; 4];
        if strength > 0.0 {
            let (weight, tau) = (f64::from(strength).log2(), trace.max(1e-30).log2());
            let leaf = skip as usize == node + 1;
            let rule = if leaf { LAW_SAMPLE } else { LAW_MOMENTS };
            let valid = |chi: f64| {
                let s = chi_distance(tau.exp2(), sigma, chi);
                (s * s - nearest * nearest).max(0.0).sqrt()
            };
            let accept = range(rule, weight + power[rule] * tau, error);
            let accept = if leaf { accept.max(valid(SAMPLE_CHI)) } else { accept };
            // The laws hold at a cluster's nearest point, hence the radius, but at a triangle's centroid. A distance
            // of 0 means that they hold everywhere.
            let reach = |radius: f64, range: f64| if range > 0.0 { (radius + range) as f32 } else { -1e9 };
            let edge = if leaf { 0.0 } else { radius };
            emitter.place[3] = reach(radius, range(LAW_MAGNITUDE, weight, DROPPED_SHARE * error));
            emitter.accept = reach(edge, accept);
            expands = BLOCK_CLASSES.map(|moment| {
                let moment = (disc * f64::from(moment)).max(1e-30).log2();
                reach(
                    edge,
                    accept.max(range(LAW_EXPANSION, weight + power[LAW_EXPANSION] * moment, EXPANDED_SHARE * error)),
                )
            });
            if leaf {
                emitter.area = reach(edge, valid(AREA_CHI).max(range(LAW_AREA, weight + power[LAW_AREA] * tau, error)));
            }
        }
        (emitter, expands)
    };
    let (emitters, expands): (Vec<Emitter>, Vec<[f32; 4]>) =
        (0..data.topology.len()).into_par_iter().map(emitter).unzip();
    data.emitters[base..base + emitters.len()].copy_from_slice(&emitters);
    data.expansion_distances[base..base + expands.len()].copy_from_slice(&expands);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let group = pass.object().groups[pass.at.group];
    let (any_light, order) = (u32::from(pass.state.any_light(pass.at)), pass.state.moment_order(pass.at));
    let layers = u32::from(pass.object().solves());
    pass.dispatch(Some("table"), &[group.channels, order, any_light, layers], &[], ERROR_LAWS * RANGE_ENTRIES)?;
    pass.dispatch(Some("node"), &[order, any_light, layers], &[], pass.object().count.nodes)
}
