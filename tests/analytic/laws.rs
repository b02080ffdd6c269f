//! The numbers that choose the lists of a block, against their definitions: samples of the light's level, contrast, and
//! the tables of distances.

use milkglass::internals::dipole::form_factor::ladder::q2;
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::layout::{COARSE_SAMPLES, CONTRAST_LEAST, ERROR_LAWS, RANGE_ENTRIES};
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

fn solved(mode: Mode) -> Session {
    let sets =
        ["object.0.detail=3", "light=[{ type = 'directional', direction = [1, 2, 3], irradiance = [3, 1, 0.4] }]"];
    let scene = Scene::load_with("sphere", &sets.map(String::from)).unwrap();
    let mut session =
        Session::new(&scene, None, Options { mode, goal: Goal::Radiosity, ..Options::default() }).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

#[test]
fn tables_of_distances_give_back_their_laws() {
    let session = solved(Mode::OnTheFly);
    let data = &session.state().data;
    let params = &data.object_params[0];
    // The leading error of a rule of exponent n is (q2(a) / 2 s^2)^n of the light, in units of the reference level.
    let law = |n: f64, distance: f64| {
        let channel = |c: usize| {
            let dipole = Dipole::of(params, c);
            let source = |z: f64| {
                let s = distance.hypot(z);
                let a = dipole.sigma * s;
                z * (1.0 + a) * (-a).exp() / s.powi(3) * (0.5 * q2(a) / (s * s)).powf(n)
            };
            let strength = dipole.strength * f64::from(params.tint[c]);
            strength * dipole.depths().map(source).iter().sum::<f64>() / f64::from(data.reference_level[0][c])
        };
        (0..3).map(channel).fold(0.0, f64::max)
    };
    // Second moments: clusters err by 1.5, expansions by 1.5, single samples by 2, area points by 3.
    let powers = [0.0, 1.5, 1.5, 2.0, 3.0];
    assert_eq!(data.ranges.len(), ERROR_LAWS * (RANGE_ENTRIES + 2));
    for (table, n) in data.ranges.chunks_exact(RANGE_ENTRIES + 2).zip(powers) {
        let (top, depth) = (f64::from(table[0]), f64::from(table[1]));
        for (entry, &distance) in table[2..].iter().enumerate() {
            let expected = top - depth * entry as f64 / (RANGE_ENTRIES - 1) as f64;
            let found = law(n, distance.into()).log2();
            assert!((found - expected).abs() < 5e-3, "{n}, entry {entry}, {distance}: {found} {expected}");
        }
    }
}

#[test]
fn the_first_half_of_the_samples_is_even() {
    let session = solved(Mode::OnTheFly);
    let data = &session.state().data;
    let (half, count) = (COARSE_SAMPLES / 2, data.triangles.len());
    assert_eq!(data.samples.len(), COARSE_SAMPLES);
    for (k, sample) in data.samples[..half].iter().enumerate() {
        assert_eq!(sample.face as usize, (2 * k + 1) * count / (2 * half), "sample {k}");
    }
}

#[test]
fn contrast_is_the_spread_of_light_over_its_level() {
    let session = solved(Mode::Render);
    let data = &session.state().data;
    assert!(session.state().method.any_light);
    let square = data.samples.iter().map(|sample| f64::from(sample.light)).sum::<f64>() / COARSE_SAMPLES as f64;
    let mean = f64::from(data.moments[0].weight) / f64::from(data.clusters[0].area);
    for c in 0..3 {
        let tint = f64::from(data.object_params[0].tint[c]);
        let exact = square.sqrt() * mean * tint / f64::from(data.reference_level[0][c]);
        // Rounded up in steps of a quarter octave.
        let found = f64::from(data.counters[0].contrast[c]);
        assert!(exact > f64::from(CONTRAST_LEAST), "{exact}");
        assert!(found > 0.9999 * exact && found < 1.0001 * exact * 2f64.powf(0.25), "{c}: {found} {exact}");
    }
}

#[test]
fn clusters_without_a_border_are_no_polygon() {
    let sets = ["object.0.detail=3", "transport.scheme=links"].map(String::from);
    let scene = Scene::load_with("sphere", &sets).unwrap();
    let mut session = Session::new(&scene, None, Options { goal: Goal::Radiosity, ..Options::default() }).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let data = &session.state().data;
    let reaches = data.cluster_reach.iter().zip(&data.borders);
    assert!(reaches.clone().all(|(&reach, border)| (reach > 0.0) == (border[1] > 0)));
    assert!(reaches.clone().any(|(_, border)| border[1] > 0) && data.borders.iter().any(|border| border[1] == 0));
}
