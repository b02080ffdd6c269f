//! Errors of the march through layers and of its approximations, on planes and on curved scenes.

use milkglass::measure::layers::{Looks, approximations, rules};
use milkglass::scene::Integration;

use super::scene;

const FLAT: [&str; 5] = [
    "object.0.shape=plane",
    "object.0.size=40",
    "object.0.rotation=[90, 0, 0]",
    "light.0.shadows=false",
    "light.1.shadows=false",
];

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn ours_with_ten_samples_beats_the_left_rule_with_a_hundred() {
    let small = |pixels| Looks { sizes: [[24, 20], [36, 30]], pixels };
    let fish = Looks { sizes: [[90, 68], [120, 90]], pixels: 512 };
    for (scene, looks, integration, total) in
        [(scene("slab-layers", &FLAT), small(24), 2e-3, 2e-2), (scene("fish", &[]), fish, 2e-2, 0.45)]
    {
        let lines = rules(&scene, None, &[10, 100], looks, 1).unwrap();
        let line = |rule, samples| lines.iter().find(|line| line.rule == rule && line.samples == samples).unwrap();
        let (ours, theirs) = (line(Integration::Exact, 10), line(Integration::Paper, 100));
        assert!(ours.integration < theirs.integration, "{lines:?}");
        assert!(ours.integration < integration, "{lines:?}");
        // On a plane the march makes no approximation.
        assert!(ours.totals.iter().all(|error| error.value < total), "{lines:?}");
        assert!(ours.totals.iter().all(|error| error.low <= error.value && error.value <= error.high), "{lines:?}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn on_a_plane_no_approximation_costs_anything() {
    let looks = Looks { sizes: [[24, 20], [12, 10]], pixels: 24 };
    for found in approximations(&scene("slab-layers", &FLAT), looks).unwrap() {
        assert!(found.errors.iter().all(|(_, error)| error.value < 2e-2), "{found:?}");
        assert!(found.behind == 0.0 && found.pixels[0] == found.pixels[1], "{found:?}");
    }
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn light_from_behind_thin_parts_is_part_of_the_error() {
        let looks = Looks { sizes: [[100, 75], [130, 98]], pixels: 512 };
        let both = approximations(&scene("fish", &[]), looks).unwrap();
        for found in &both {
            let [(_, shadows), .., (_, all), (_, march)] = found.errors[..] else { panic!("{found:?}") };
            assert!(found.pixels[0] >= 500, "{found:?}");
            // The fins let light through that the march does not know of: a good part of its error.
            assert!(found.behind > 0.08 && found.behind < 0.18, "{found:?}");
            assert!(shadows.low > 0.2 && found.front.value < march.value, "{found:?}");
            assert!(march.low > 0.2 && march.high < 0.5 && march.high - march.low < 0.25, "{found:?}");
            assert!((all.value / march.value - 1.0).abs() < 0.05, "{found:?}");
            assert!(found.errors.iter().all(|(_, error)| error.value > 5e-3 && error.value < 0.5), "{found:?}");
        }
        let [one, other] = [0, 1].map(|k| both[k].errors[5].1);
        assert!(one.low < other.high && other.low < one.high, "the sizes agree: {both:?}");
        // The gecko's lamps cast no shadows.
        for found in approximations(&scene("gecko", &[]), looks).unwrap() {
            assert!(found.behind == 0.0 && found.pixels[0] == found.pixels[1], "{found:?}");
            assert!(found.front.low > 0.1 && found.front.high < 0.4, "{found:?}");
        }
    }
}
