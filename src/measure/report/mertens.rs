//! Section `mertens`: figures 3 and 4 of Mertens et al. 2003 as plots, tables 3, 4 and 5 with our values.

use std::ops::Range;

use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::plot::{Axis, CHANNELS, Panel, Series};
use crate::measure::tables::curves::{Point, TOLERANCES, figure_3, figure_4};
use crate::measure::tables::figures::{NAMES, points, worst};
use crate::measure::tables::{Bench as Models, TABLES};

/// The figures, then the tables.
pub fn mertens(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    figure3(bench, page)?;
    figure4(bench, page)?;
    page.head("Tables 3, 4 and 5");
    tables(bench, page, 0..bench.either(1, TABLES.len()))?;
    if bench.quick {
        page.say(
            "Tables 4 and 5 and the larger models of table 3 are in the full report, and in `cargo bench -- tables`.",
        );
    }
    Ok(())
}

/// Figure 3.
pub fn figure3(_: &Bench<'_>, page: &mut Page) -> Result<()> {
    let points = figure_3();
    form_factor(&points, page)?;
    aim("figure 3", &points, page);
    Ok(())
}

/// Figure 4.
pub fn figure4(_: &Bench<'_>, page: &mut Page) -> Result<()> {
    let points = figure_4();
    marble(&points, page)?;
    aim("figure 4", &points, page);
    Ok(())
}

/// Table 3.
pub fn table3(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    tables(bench, page, 0..1)
}

/// Table 4.
pub fn table4(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    tables(bench, page, 1..2)
}

/// Table 5, and figure 5.
pub fn table5(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    tables(bench, page, 2..3)
}

/// Whether our form factors are as good as the published ones.
fn aim(name: &str, points: &[Point], page: &mut Page) {
    let most = |of: &dyn Fn(&Point) -> f64| points.iter().map(|p| of(p).abs()).fold(0.0, f64::max);
    let (paper, ours) = (most(&|p| p.error(p.paper.value)), most(&|p| p.error(p.ours[1].1)));
    let aim = format!("{name}: largest error at most that of the published method");
    let found = format!("ours at {:e}: {ours:.1e}, published: {paper:.1e}", TOLERANCES[1]);
    page.find(Tone::of(ours <= paper), &aim, &found);
}

/// A line of the green channel.
fn green(name: &str, points: &[Point], of: &dyn Fn(&Point) -> f64) -> Series {
    Series::line(name, points.iter().filter(|p| p.channel == 1).map(|p| (p.place, of(p).abs())))
}

fn form_factor(third: &[Point], page: &mut Page) -> Result<()> {
    page.head("Figure 3: the form factor of a triangle of skim milk");
    page.say("Base 10 mm, height 5 mm; the tip points to the receiver, which lies in the plane. Lines: exact; dots: the published method.");
    let channel = |c: usize| {
        let own = |of: fn(&Point) -> f64| third.iter().filter(move |p| p.channel == c).map(move |p| (p.place, of(p)));
        let exact = Series::line(NAMES[c], own(|p| p.exact));
        [exact, Series::dots("paper's method", own(|p| p.paper.value))].map(|series| series.colored(CHANNELS[c]))
    };
    let errors = [
        green("paper's method", third, &|p| p.error(p.paper.value)),
        green("12 random samples, rms", third, &|p| p.scatter / 12f64.sqrt()),
        green("10,000 random samples", third, &|p| p.scatter / 100.0),
        green("ours at 1e-2", third, &|p| p.error(p.ours[0].1)),
        green("ours at 1e-4", third, &|p| p.error(p.ours[1].1)),
    ];
    let tip = || Axis::linear("receiver to tip, mm");
    page.plots(&[
        Panel::new("Figure 3: form factor", [tip(), Axis::linear("F, no unit")], (0..3).flat_map(channel)).svg()?,
        Panel::new("Its error, green", [tip(), Axis::log("relative error")], errors).svg()?,
    ]);
    all_points(page, "figure-3", "tip_mm", third)
}

fn marble(fourth: &[Point], page: &mut Page) -> Result<()> {
    page.head("Figure 4: marble, from 0.1 to 100 mm");
    page.say("The receiver at the tip, the base twice as wide as its distance. Evaluations of the kernel, and the resulting error.");
    let counts = [
        green("paper's segments", fourth, &|p| p.paper.segments as f64 / 2.0),
        green("samples, Jensen and Buhler", fourth, &|p| p.discs as f64),
        green("ours at 1e-2", fourth, &|p| p.ours[0].0 as f64),
        green("ours at 1e-4", fourth, &|p| p.ours[1].0 as f64),
    ];
    let errors = [
        green("paper's method", fourth, &|p| p.error(p.paper.value)),
        green("samples, rms", fourth, &|p| p.scatter / (p.discs as f64).sqrt()),
        green("ours at 1e-2", fourth, &|p| p.error(p.ours[0].1)),
        green("ours at 1e-4", fourth, &|p| p.error(p.ours[1].1)),
    ];
    let base = || Axis::log("receiver to base, mm");
    page.plots(&[
        Panel::new("Figure 4: evaluations a source, green", [base(), Axis::log("evaluations")], counts).svg()?,
        Panel::new("Its error, green", [base(), Axis::log("relative error")], errors).svg()?,
    ]);
    all_points(page, "figure-4", "base_mm", fourth)
}

fn tables(bench: &Bench<'_>, page: &mut Page, which: Range<usize>) -> Result<()> {
    page.say(
        "The published scheme on this device; the paper's columns first. Its models are not available, so built-in shapes \
         replace them. Compare growth and ratios, not milliseconds of 2003.",
    );
    let models =
        Models { device: bench.device, meshes: bench.meshes, samples: 100, most_faces: bench.either(2_100, 17_000) };
    for (_, measure) in &TABLES[which] {
        // Rows take minutes: each is kept at once.
        let found = measure(&models, &mut |so_far| {
            bench.keep(&format!("{}.csv", so_far.name), so_far.table.csv()?.as_bytes())
        })?;
        for beside in found {
            beside.before.iter().for_each(|words| page.say(words));
            page.table(&beside.name, &beside.table)?;
            beside.after.iter().for_each(|words| page.say(words));
        }
    }
    Ok(())
}

/// Adds all points as a file, and the worst.
fn all_points(page: &mut Page, name: &str, place: &str, all: &[Point]) -> Result<()> {
    page.small_table(&worst(all));
    page.fold("All points", |page| page.table(name, &points(place, all)))
}
