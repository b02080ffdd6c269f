//! Clusters by their moments: the link of a cloud of points against the sum over them, the distance at which it holds,
//! and the moments that the tree pulls up against sums over triangles.

use glam::{DMat3, DVec3};
use milkglass::internals::dipole::derivatives::{ClusterMoments, GroupProfile};
use milkglass::internals::dipole::form_factor::ladder::{chi, chi_distance};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::layout::{FAINTEST, FARTHEST, NONE, ObjectParams};
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use crate::population::seeded::Seeded;

/// Three channels of a unit medium, untinted.
fn params() -> ObjectParams {
    let dipoles = [(2.6, 0.004), (8.0, 0.3), (1.0, 1.0)].map(|(s, a)| Dipole::new(s, a, 3.96));
    ObjectParams {
        strength: dipoles.map(|dipole| dipole.strength as f32),
        sigma: dipoles.map(|dipole| dipole.sigma as f32),
        z_real: dipoles.map(|dipole| dipole.z_real as f32),
        z_virtual: dipoles.map(|dipole| dipole.z_virtual as f32),
        tint: [1.0, 0.5, 0.25],
        ..ObjectParams::default()
    }
}

/// The columns of a symmetric matrix from its diagonal, and yz, zx, xy.
fn symmetric([d, m]: [DVec3; 2]) -> DMat3 {
    DMat3::from_cols(DVec3::new(d.x, m.z, m.y), DVec3::new(m.z, d.y, m.x), DVec3::new(m.y, m.x, d.z))
}

#[test]
fn a_link_is_the_sum_over_its_points_to_fourth_order() {
    let params = params();
    let profile = GroupProfile::new(&params, 0b111);
    let mut random = Seeded(11);
    for _ in 0..200 {
        // Pairs of points on either side of the centre: the odd orders cancel.
        let center = random.direction();
        let arms: Vec<(DVec3, f64)> =
            (0..6).map(|_| (random.direction() * random.between(0.1, 1.0), random.between(0.1, 1.0))).collect();
        let weight: f64 = arms.iter().map(|arm| arm.1).sum();
        let x = center + random.direction() * random.between(0.4, 3.0);
        for (c, tint) in [1.0, 0.5, 0.25].into_iter().enumerate() {
            let dipole = Dipole::of(&params, c);
            let error = |size: f64, order: u32| {
                let mean = |f: &dyn Fn(DVec3) -> DVec3| -> DVec3 {
                    arms.iter().map(|&(arm, w)| w * f(size * arm)).sum::<DVec3>() / weight
                };
                let moments = [mean(&|v| v * v), mean(&|v| DVec3::new(v.y * v.z, v.z * v.x, v.x * v.y))];
                let cloud = ClusterMoments { weight, center, moments };
                let at = |way: DVec3| tint * dipole.reflectance(x.distance(center + way));
                let sum: f64 = arms.iter().map(|&(arm, w)| 0.5 * w * (at(size * arm) + at(-size * arm))).sum();
                (profile.link(c, &cloud, x, order) - sum).abs() / sum
            };
            // Halving the cloud divides the error by 16, without its second moments by 4.
            let (coarse, fine, plain) = (error(0.04, 2), error(0.02, 2), error(0.02, 1));
            assert!(fine < 2e-4 && fine < coarse / 12.0 + 1e-12 && plain < 0.05, "{c}: {coarse} {fine} {plain}");
        }
    }
}

#[test]
fn beyond_its_distance_chi_is_below_the_limit() {
    // Without absorption chi is 15 tau / (2 s^2).
    for (tau, limit) in [(1e-4_f64, 0.1), (1e-2, 0.3), (1e-6, 0.02)] {
        let expected = (7.5 * tau / limit).sqrt();
        assert!((chi_distance(tau, [0.0; 3], limit) / expected - 1.0).abs() < 1e-12);
        for sigma in [0.3, 4.0, 30.0] {
            let [least, most] = [chi_distance(tau, [0.0; 3], limit), chi_distance(tau, [0.0, sigma, 0.0], limit)];
            // The distance is that of the channel that needs the most; chi there is within the limit, not far below it.
            let at = chi(tau, sigma, most);
            assert!(most >= least && (at <= limit || (sigma * most - FAINTEST).abs() < 1e-9), "{tau} {sigma}: {at}");
            assert!(at > 0.5 * limit || most <= 1.01 * least, "{tau} {sigma}: {at} of {limit}");
        }
    }
    // Where no distance serves: the one of the faintest light that counts, or the farthest.
    assert_eq!(chi_distance(1e9, [0.0; 3], 1e-9), FARTHEST);
    assert_eq!(chi_distance(1.0, [10.0; 3], 1e-3), FAINTEST / 10.0);
}

#[test]
fn clusters_are_the_sums_of_their_triangles() {
    let sets = ["object.0.detail=16".to_string(), "object.0.deform=[{ type = 'twist', angle = 90 }]".to_string()];
    let scene = Scene::load_with("lotus", &sets).unwrap();
    let mut session = Session::new(&scene, None, Options { goal: Goal::Radiosity, ..Options::default() }).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let (data, wide) = (&session.state().data, |v: [f32; 3]| DVec3::from_array(v.map(f64::from)));
    for (node, place) in data.topology.iter().enumerate() {
        let below = (node..place.skip as usize).map(|k| data.topology[k].face).filter(|&face| face != NONE);
        let triangles: Vec<[DVec3; 3]> =
            below.map(|face| data.triangles[face as usize].map(|v| wide(data.positions[v as usize]))).collect();
        let normal = |[a, b, c]: &[DVec3; 3]| 0.5 * (b - a).cross(c - a);
        let area: f64 = triangles.iter().map(|t| normal(t).length()).sum();
        let center = triangles.iter().map(|t| normal(t).length() * (t[0] + t[1] + t[2]) / 3.0).sum::<DVec3>() / area;
        // The mean squared distance from the centre, exact by the midpoints of a triangle's edges.
        let squares = |t: &[DVec3; 3]| {
            let middles = [t[0] + t[1], t[1] + t[2], t[2] + t[0]].map(|sum| (0.5 * sum).distance_squared(center));
            normal(t).length() * middles.iter().sum::<f64>() / 3.0
        };
        let trace = triangles.iter().map(squares).sum::<f64>() / area;
        let found = &data.clusters[node];
        assert!((f64::from(found.area) / area - 1.0).abs() < 1e-6, "area of node {node}");
        assert!(wide(found.center).distance(center) < 1e-6, "centre of node {node}");
        assert!(wide(found.normal).distance(triangles.iter().map(normal).sum()) < 1e-6 * area, "normal of node {node}");
        assert!((f64::from(found.moment_trace) / trace - 1.0).abs() < 1e-5, "second moment of node {node}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn moments_of_clusters_are_those_of_their_triangles() {
    let scene = Scene::load_with("lotus", &["object.0.detail=16".to_string()]).unwrap();
    let mut session = Session::new(&scene, None, Options { goal: Goal::Radiosity, ..Options::default() }).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let (state, wide) = (session.state(), |v: [f32; 3]| DVec3::from_array(v.map(f64::from)));
    let (data, lead) = (&state.data, state.objects[0].groups[0].lead as usize);
    let sigma = data.object_params[0].sigma.map(f64::from);
    let mut lit = 0;
    for (node, place) in data.topology.iter().enumerate() {
        let below = (node..place.skip as usize).map(|k| data.topology[k].face).filter(|&face| face != NONE);
        let triangles: Vec<([DVec3; 3], f64)> = below
            .map(|face| {
                let corners = data.triangles[face as usize].map(|v| wide(data.positions[v as usize]));
                let [a, b, c] = corners;
                let light = f64::from(data.irradiance[face as usize][lead]);
                (corners, 0.5 * (b - a).cross(c - a).length() * light)
            })
            .collect();
        let weight: f64 = triangles.iter().map(|(_, weight)| weight).sum();
        let (found, second) = (&data.moments[node], &data.second_moments[node]);
        assert!((f64::from(found.weight) - weight).abs() <= 2e-6 * weight, "{node}: {} {weight}", found.weight);
        if weight <= 0.0 {
            continue;
        }
        lit += 1;
        let middle = |t: &[DVec3; 3]| (t[0] + t[1] + t[2]) / 3.0;
        let center = triangles.iter().map(|(t, w)| *w * middle(t)).sum::<DVec3>() / weight;
        assert!(wide(found.center).distance(center) < 2e-6, "{node}: {} {center}", wide(found.center));
        // A triangle's second moment is that of its edges' midpoints, a third of its weight each.
        let outer = |v: DVec3| DMat3::from_cols(v.x * v, v.y * v, v.z * v);
        let mut tensor = DMat3::ZERO;
        for &([a, b, c], w) in &triangles {
            for middle in [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)] {
                tensor += outer(middle - center) * (w / (3.0 * weight));
            }
        }
        let trace = tensor.x_axis.x + tensor.y_axis.y + tensor.z_axis.z;
        let stored = symmetric([wide(second.diagonal), wide(second.mixed)]);
        let apart = (stored - tensor).to_cols_array().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(apart < 1e-5 * trace + 1e-12, "{node}: {stored} {tensor}");
        // No corner is beyond the radius, and the radius is less than twice as large as it has to be.
        let reach = triangles.iter().flat_map(|(t, _)| t).fold(0.0, |most: f64, p| most.max(p.distance(center)));
        let radius = f64::from(second.radius);
        assert!(radius > 0.9999 * reach && radius < 2.0 * reach + 1e-6, "{node}: {radius} {reach}");
        let far = f64::from(second.coarse) - radius;
        let within = |&sigma: &f64| chi(trace, sigma, far) < 1.0 || sigma * far > 0.99 * FAINTEST;
        assert!(far > 0.0 && (sigma.iter().all(within) || far > 0.99 * FARTHEST), "{node}: {far}");
    }
    assert!(lit > 300, "{lit}");
}
