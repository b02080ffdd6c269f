//! Section `accuracy`: numerical error beside the model's error.

use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::accuracy::{Effort, PATHS, Pair, models, numerical};
use crate::measure::plot::{Axis, Panel, Series};
use crate::measure::table::Table;
use crate::scene::PRESETS;

const WALK: &str = "the same by a random walk, and its standard error";
const ERROR: &str = "the dipole's error, per cent of the walk's value";
/// The columns of the table: names, and what they mean.
const COLUMNS: [(&str, &str); 18] = [
    ("material", ""),
    ("channel", ""),
    ("albedo'", "reduced albedo: scattering over extinction"),
    ("plane, collimated: dipole", "share of perpendicular light that a half-space returns, by the dipole"),
    ("plane, collimated: walk", WALK),
    ("plane, collimated: error %", ERROR),
    ("plane, constant: dipole", "share of light from all sides that a half-space returns"),
    ("plane, constant: walk", WALK),
    ("plane, constant: error %", ERROR),
    ("slab, passes: dipole", "share of light that passes a slab"),
    ("slab, passes: walk", WALK),
    ("slab, passes: error %", ERROR),
    ("ball, constant: dipole", "share of light from all sides that a ball returns"),
    ("ball, constant: walk", WALK),
    ("ball, constant: error %", ERROR),
    ("ball, collimated: L2 %", "the dipole's error on a ball in the sun: L2 over its surface, against the walk"),
    ("walk's noise %", "the walk's own noise, which is taken off that"),
    ("numerical %", "our error against brute force with the same dipole"),
];

/// Measures all presets and channels.
pub fn accuracy(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let effort = Effort { photons: bench.either(1_000, 40_000), samples: 100, detail: bench.either(3, 5), seed: 1 };
    page.say(&format!(
        "Numerical error: our radiosity against brute force in f64 over the same triangles, L2, worst channel, on a ball of {PATHS} \
         mean free paths in the sun. Model error: the dipole against the random walk of {} photons (--transport walk) with even scattering by \
         the reduced coefficient and Fresnel's reflection at the surface, of light that has entered, without what passes straight \
         through; \u{b1} is the walk's standard error. A plane is a half-space, a slab and the balls measure {PATHS} mean free \
         paths of their channel.",
        effort.photons
    ));
    let percent = |x: f64| format!("{:+.1}", 100.0 * x);
    let cells = |pair: &Pair| {
        [
            format!("{:.4}", pair.dipole),
            format!("{:.4} \u{b1} {:.4}", pair.walk.mean, pair.walk.error),
            percent(pair.error()),
        ]
    };
    let (mut rows, mut errors) = (Vec::new(), Vec::new());
    let mut dots: [Vec<(f64, f64)>; 3] = Default::default();
    for preset in PRESETS {
        let numeric = numerical(preset, bench.device, effort)?;
        let models = models(preset, bench.device, effort)?;
        for (found, channel) in models.iter().zip(["red", "green", "blue"]) {
            let mut row = vec![preset.name.to_string(), channel.to_string(), format!("{:.5}", found.albedo)];
            let pairs = found.plane.iter().chain([&found.slab, &found.constant]);
            row.extend(pairs.flat_map(cells));
            row.extend([format!("{:.1}", 100.0 * found.ball), format!("{:.1}", 100.0 * found.noise)]);
            row.push(format!("{:.3}", 100.0 * numeric));
            rows.push(row);
            errors.push((found.ball, numeric));
            let absorbed = (1.0 - found.albedo).max(1e-6);
            dots[0].push((absorbed, 100.0 * found.plane[1].error().abs()));
            dots[1].push((absorbed, 100.0 * found.ball));
            dots[2].push((absorbed, 100.0 * numeric));
        }
    }
    let [plane, ball, ours] = dots;
    let series = [
        Series::dots("model: plane, constant light", plane),
        Series::dots("model: ball, collimated light", ball),
        Series::dots("numerical: ours", ours),
    ];
    let axes = [Axis::log("1 - reduced albedo"), Axis::log("error, %")];
    page.plot(&Panel::new("Model error and numerical error", axes, series).svg()?, false);
    page.table("accuracy", &Table::new(COLUMNS, rows))?;
    find(&errors, page);
    Ok(())
}

/// Tells the medians of the errors of the model on balls, and of ours.
fn find(errors: &[(f64, f64)], page: &mut Page) {
    let middle = |of: fn(&(f64, f64)) -> f64| {
        let mut list: Vec<f64> = errors.iter().map(of).collect();
        list.sort_by(f64::total_cmp);
        list[list.len() / 2]
    };
    let (model, ours) = (middle(|e| e.0), middle(|e| e.1));
    let tone = Tone::of(ours < 0.1 * model);
    let found = format!("{:.2} % (median over the materials, balls in the sun)", 100.0 * ours);
    page.find(tone, "numerical error below a tenth of the model's", &found);
    let (of, paths) = (PRESETS.len(), PATHS);
    let found = format!("{:.0} % off (median of {of} materials, balls of {paths} mean free paths)", 100.0 * model);
    page.find(Tone::Loss, "the dipole agrees with a random walk", &found);
    page.tile(Tone::Loss, &format!("{:.0} %", 100.0 * model), "error of the dipole model itself, against random walks");
}
