//! Section `layers`: table 2 and figure 14 of Francois et al. 2006.

use super::pictures::{Shot, scene};
use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::layers::{
    Line as Measured, Looks, PAPER, SAMPLES, SWEEP, approximations, by_lights, dearer, rules,
};
use crate::measure::plot::{Axis, Panel, Series};
use crate::measure::statistics::median;
use crate::measure::table::Table;
use crate::pipeline::plan::ShadingMethod;
use crate::scene::Integration;

const RULES: [(Integration, &str); 2] = [(Integration::Paper, "paper's rule"), (Integration::Exact, "ours")];

const IN_ALL: &str = "relative error against the layered volume itself, with its 95 % interval";

fn named(rule: Integration) -> &'static str {
    RULES.iter().find(|(known, _)| *known == rule).map_or("", |(_, name)| name)
}

/// Errors and times by number of samples, cost by number of lights, each approximation on its own, and pictures of
/// the fish.
pub fn francois(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let looks = looks(bench);
    integration(bench, page, looks)?;
    lights(bench, page, looks.sizes[0])?;
    alone(page, looks)?;
    pictures(bench, page)
}

/// Table 2 alone.
pub fn table2(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    integration(bench, page, looks(bench))
}

/// How large pictures are, and at how many pixels errors are measured.
fn looks(bench: &Bench<'_>) -> Looks {
    let size = bench.either([120, 90], [800, 600]);
    Looks { sizes: bench.either([size, [240, 180]], [size, [400, 300]]), pixels: bench.either(512, 2048) }
}

/// Frames that are timed.
fn repeat(bench: &Bench<'_>) -> usize {
    bench.either(3, 7)
}

/// Errors and times of both rules, by number of samples.
fn integration(bench: &Bench<'_>, page: &mut Page, looks: Looks) -> Result<()> {
    page.head("Table 2: samples, error and time");
    page.say(
        "Error of the integration alone, and of everything together, with its 95 % confidence interval over the pixels \
         sampled. The paper's frames per second are those of a GeForce 7800 GTX at 800 x 600.",
    );
    let mut rows: Vec<(&str, Measured)> = Vec::new();
    for name in ["slab-layers", "fish", "gecko"] {
        let samples: &[u32] = if name == "fish" { &SWEEP } else { &SAMPLES };
        let lines = rules(&scene(name, looks.sizes[0], &[])?, bench.device, samples, looks, repeat(bench))?;
        rows.extend(lines.iter().filter(|line| SAMPLES.contains(&line.samples)).map(|line| (name, line.clone())));
        if name == "fish" {
            plots(&lines, page)?;
        }
        find(name, &lines, page);
    }
    page.table("layers", &table_2(&rows, looks))
}

/// Error of each rule by its samples, and by its time.
fn plots(lines: &[Measured], page: &mut Page) -> Result<()> {
    let by_rule = |rule: Integration| lines.iter().filter(move |line| line.rule == rule);
    let plot = |title: &str, x: &str, by: fn(&Measured) -> f64| {
        let errors = |rule| by_rule(rule).map(move |line| (by(line), line.integration));
        let series = RULES.map(|(rule, name)| Series::line(name, errors(rule)));
        Panel::new(title, [Axis::log(x), Axis::log("relative error, L2")], series).svg()
    };
    page.plots(&[
        plot("Figure 14: error by samples, fish", "samples", |line| f64::from(line.samples))?,
        plot("Error by time, fish", "stage relief, ms", |line| line.relief)?,
    ]);
    Ok(())
}

/// What ten samples err, and what one costs, beside the published rule.
fn find(name: &str, lines: &[Measured], page: &mut Page) {
    let at = |rule, samples| lines.iter().find(|line| line.rule == rule && line.samples == samples);
    if let (Some(ours), Some(theirs)) = (at(Integration::Exact, 10), at(Integration::Paper, 100)) {
        let tone = Tone::of(ours.integration <= theirs.integration);
        let (ours, theirs) = (ours.integration, theirs.integration);
        let aim = format!("{name}: 10 samples err no more than 100 of the published rule");
        page.find(tone, &aim, &format!("{ours:.1e} against {theirs:.1e}"));
    }
    let cost = |&samples: &u32| Some(at(Integration::Exact, samples)?.relief / at(Integration::Paper, samples)?.relief);
    let costs: Vec<f64> = SAMPLES.iter().filter_map(cost).collect();
    let cost = median(costs);
    let tone = Tone::of(cost <= 1.2);
    let aim = format!("{name}: a sample takes at most 1.2 of the time of one of the published rule");
    page.find(tone, &aim, &format!("{cost:.2}"));
}

/// Cost by number of lights.
fn lights(bench: &Bench<'_>, page: &mut Page, size: [u32; 2]) -> Result<()> {
    page.head("Cost by lights");
    let counts = bench.either(&[1, 2, 4][..], &[1, 2, 4, 8, 16]);
    let costs = by_lights(&scene("fish", size, &[])?, bench.device, counts, repeat(bench))?;
    let most = dearer(&costs);
    let aim = "fish: of several lights each takes at most 1.1 of the time of one alone";
    page.find(Tone::of(most <= 1.1), aim, &format!("at most {most:.2}"));
    let table = Table::of(
        &costs,
        &[
            ("point lights", "", &|(count, _)| count.to_string()),
            ("relief, ms", "time of stage relief", &|(_, ms)| format!("{ms:.2}")),
            ("ms a light", "", &|(count, ms)| format!("{:.2}", ms / f64::from(*count))),
        ],
    );
    page.table("layers-lights", &table)
}

/// Each approximation alone, and light from behind.
fn alone(page: &mut Page, looks: Looks) -> Result<()> {
    page.head("Each approximation by itself");
    let (mut rows, mut behind) = (Vec::new(), Vec::new());
    for name in ["slab-layers", "fish", "gecko"] {
        let both = approximations(&scene(name, looks.sizes[0], &[])?, looks)?;
        for ((what, one), (_, other)) in both[0].errors.iter().zip(&both[1].errors) {
            rows.push(vec![name.to_string(), (*what).to_string(), one.to_string(), other.to_string()]);
        }
        for (found, [width, height]) in both.iter().zip(looks.sizes) {
            let all = found.errors.last().map_or(String::new(), |(_, all)| all.to_string());
            let [pixels, front] = found.pixels.map(|n| n.to_string());
            let share = format!("{:.2}", 100.0 * found.behind);
            let size = format!("{width} x {height}");
            behind.push(vec![name.to_string(), size, pixels, all, share, front, found.front.to_string()]);
        }
    }
    let sized = looks.sizes.map(|[width, height]| format!("L2, {width} x {height}"));
    let columns = [
        ("scene", ""),
        ("approximation", "made alone, everything else converged"),
        (&*sized[0], "its relative error, against the layered volume without it, with its 95 % interval"),
        (&*sized[1], "the same at the other size"),
    ];
    page.table("layers-approximations", &Table::new(columns, rows))?;
    page.say(
        "Light that comes through thin parts from lamps that do not reach the visible triangle is in the volume, not in the \
         march.",
    );
    let columns = [
        ("scene", ""),
        ("picture", "width and height, pixels"),
        ("pixels", "sampled"),
        ("L2", "relative error of the converged march over all of them, with its 95 % interval"),
        ("from behind, %", "share of the volume's light from lamps that do not reach the visible triangle"),
        ("pixels in front", "those with at most 1 % of such light"),
        ("L2 in front", "relative error over these, with its 95 % interval"),
    ];
    page.table("layers-behind", &Table::new(columns, behind))
}

/// The fish by both rules, and what differs.
pub fn pictures(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("The fish by its samples");
    let size = bench.either([240, 180], [480, 360]);
    for samples in SAMPLES {
        let shoot = |(rule, _): (Integration, &str)| {
            let mut scene = scene("fish", size, &[])?;
            for layers in scene.objects.iter_mut().filter_map(|object| object.material.layers.as_mut()) {
                (layers.samples, layers.integration) = (samples, rule);
            }
            Shot::take(&scene, bench.device, ShadingMethod::Hierarchy)
        };
        let [paper, ours] = [shoot(RULES[0])?, shoot(RULES[1])?];
        let (mean, map) = ours.apart(&paper)?;
        let label = |name: &str| format!("{name}, {samples} samples");
        page.pictures(&[
            paper.show(label(RULES[0].1))?,
            ours.show(label(RULES[1].1))?,
            map.show(format!("difference, FLIP {mean:.1e}"))?,
        ]);
    }
    Ok(())
}

/// Errors and times of each scene, rule and number of samples.
fn table_2(rows: &[(&str, Measured)], looks: Looks) -> Table {
    let [large, small] = looks.sizes.map(|[width, height]| format!("L2 in all, {width} x {height}"));
    let theirs = |(name, line): &(&str, Measured)| {
        let row = PAPER.iter().find(|(samples, ..)| *samples == line.samples && line.rule == Integration::Paper);
        row.and_then(|&(_, fish, gecko)| match *name {
            "fish" => Some(fish.to_string()),
            "gecko" => Some(gecko.to_string()),
            _ => None,
        })
    };
    Table::of(
        rows,
        &[
            ("scene", "", &|(name, _)| (*name).into()),
            ("rule", "how the march sums up light along the ray: as published, or ours", &|(_, line)| {
                named(line.rule).into()
            }),
            ("samples", "per ray", &|(_, line)| line.samples.to_string()),
            ("L2 of integration", "relative error against the same march with very many samples", &|(_, line)| {
                format!("{:.1e}", line.integration)
            }),
            (&large, IN_ALL, &|(_, line)| line.totals[0].to_string()),
            (&small, IN_ALL, &|(_, line)| line.totals[1].to_string()),
            ("relief, ms", "time of stage relief", &|(_, line)| format!("{:.2}", line.relief)),
            ("a view, ms", "time of a frame in which the view changes", &|(_, line)| format!("{:.2}", line.view)),
            ("views/s", "frames per second of that kind", &|(_, line)| format!("{:.0}", 1e3 / line.view)),
            ("paper's", "frames per second in the paper", &|row| theirs(row).unwrap_or_default()),
        ],
    )
}
