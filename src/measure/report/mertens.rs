//! Section `mertens`: figures 3 and 4 of Mertens et al. 2003 as plots, tables 3, 4 and 5 with our values.

use super::chart::{Axis, CHANNELS, Line, chart};
use super::html::csv_of;
use super::{Bench, Column, Page, Tone};
use crate::error::Result;
use crate::measure::tables::curves::{Point, TOLERANCES, figure_3, figure_4};
use crate::measure::tables::{Bench as Models, TABLES, Told};

/// A table: its name, its column headings, its rows.
type Measured = (String, Vec<String>, Vec<Vec<String>>);

const NAMES: [&str; 3] = ["red", "green", "blue"];

/// The figures, then the tables.
pub fn mertens(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("Figure 3: the form factor of a triangle of skim milk");
    page.say("Base 10 mm, height 5 mm; the tip points to the receiver, which lies in the plane. Lines: exact; dots: the published method.");
    let third = figure_3();
    let place = Axis { label: "receiver to tip, mm", log: false };
    let channel = |c: usize| {
        let own = |of: fn(&Point) -> f64| third.iter().filter(move |p| p.channel == c).map(move |p| (p.place, of(p)));
        let colored = |line: Line| Line { color: Some(CHANNELS[c]), ..line };
        let exact = Line::new(NAMES[c], own(|p| p.exact));
        [exact, Line::dots("paper's method", own(|p| p.paper.value))].map(colored)
    };
    let lines: Vec<Line> = (0..3).flat_map(channel).collect();
    let error = Axis { label: "relative error", log: true };
    let green = |points: &[Point], of: &dyn Fn(&Point) -> f64| -> Vec<(f64, f64)> {
        points.iter().filter(|p| p.channel == 1).map(|p| (p.place, of(p).abs())).collect()
    };
    let errors = [
        Line::new("paper's method", green(&third, &|p| p.error(p.paper.value))),
        Line::new("12 random samples, rms", green(&third, &|p| p.scatter / 12f64.sqrt())),
        Line::new("10,000 random samples", green(&third, &|p| p.scatter / 100.0)),
        Line::new("ours at 1e-2", green(&third, &|p| p.error(p.ours[0].1))),
        Line::new("ours at 1e-4", green(&third, &|p| p.error(p.ours[1].1))),
    ];
    page.plots(&[
        chart("Figure 3: form factor", place, Axis { label: "F, no unit", log: false }, &lines)?,
        chart("Its error, green", place, error, &errors)?,
    ]);
    csv(page, "figure-3", "tip_mm", &third)?;

    page.head("Figure 4: marble, from 0.1 to 100 mm");
    page.say("The receiver at the tip, the base twice as wide as its distance. Evaluations of the kernel, and the resulting error.");
    let fourth = figure_4();
    let place = Axis { label: "receiver to base, mm", log: true };
    let counts = [
        Line::new("paper's segments", green(&fourth, &|p| p.paper.segments as f64 / 2.0)),
        Line::new("samples, Jensen and Buhler", green(&fourth, &|p| p.discs as f64)),
        Line::new("ours at 1e-2", green(&fourth, &|p| p.ours[0].0 as f64)),
        Line::new("ours at 1e-4", green(&fourth, &|p| p.ours[1].0 as f64)),
    ];
    let errors = [
        Line::new("paper's method", green(&fourth, &|p| p.error(p.paper.value))),
        Line::new("samples, rms", green(&fourth, &|p| p.scatter / (p.discs as f64).sqrt())),
        Line::new("ours at 1e-2", green(&fourth, &|p| p.error(p.ours[0].1))),
        Line::new("ours at 1e-4", green(&fourth, &|p| p.error(p.ours[1].1))),
    ];
    page.plots(&[
        chart("Figure 4: evaluations a source, green", place, Axis { label: "evaluations", log: true }, &counts)?,
        chart("Its error, green", place, error, &errors)?,
    ]);
    csv(page, "figure-4", "base_mm", &fourth)?;
    for (name, points) in [("figure 3", &third), ("figure 4", &fourth)] {
        let most = |of: &dyn Fn(&Point) -> f64| points.iter().map(|p| of(p).abs()).fold(0.0, f64::max);
        let (paper, ours) = (most(&|p| p.error(p.paper.value)), most(&|p| p.error(p.ours[1].1)));
        let tone = Tone::of(ours <= paper);
        let aim = format!("{name}: largest error at most that of the published method");
        page.find(tone, &aim, &format!("ours at {:e}: {ours:.1e}, published: {paper:.1e}", TOLERANCES[1]));
    }

    page.head("Tables 3, 4 and 5");
    page.say(
        "The published scheme on this device; the paper's columns first. Its models are not available, so built-in shapes \
         replace them. Compare growth and ratios, not milliseconds of 2003.",
    );
    let models = Models { device: bench.device, meshes: &[], samples: 100, most_faces: bench.either(2_100, 17_000) };
    for (_, table) in TABLES.iter().take(bench.either(1, TABLES.len())) {
        let (mut open, mut all): (Option<Measured>, Vec<std::result::Result<Measured, String>>) = (None, Vec::new());
        let mut lost = None;
        table(&models, &mut |told| match told {
            Told::Words(words) => {
                all.extend(open.take().map(Ok));
                all.push(Err(words.trim().into()));
            }
            Told::Columns(name, header) => {
                all.extend(open.take().map(Ok));
                open = Some((name.into(), header.iter().map(ToString::to_string).collect(), Vec::new()));
            }
            Told::Row(cells) => {
                let Some((name, header, rows)) = &mut open else { return };
                rows.push(cells.to_vec());
                // Rows take minutes: each is kept at once.
                let kept =
                    csv_of(name, &explained(header), rows).and_then(|bytes| bench.keep(&format!("{name}.csv"), &bytes));
                lost = lost.take().or(kept.err());
            }
        })?;
        lost.take().map_or(Ok(()), Err)?;
        all.extend(open.map(Ok));
        for part in all {
            match part {
                Ok((name, header, rows)) => {
                    page.table(&name, &explained(&header), &rows)?;
                }
                Err(words) => page.say(&words),
            }
        }
    }
    if bench.quick {
        page.say("Tables 4 and 5 and the larger models of table 3 are in the full report, and in `cargo bench --bench tables`.");
    }
    Ok(())
}

/// Columns with what they mean.
fn explained(header: &[String]) -> Vec<Column<'_>> {
    header.iter().map(|head| (head.as_str(), meaning(head))).collect()
}

/// What a column of tables 3 to 5 means.
fn meaning(head: &str) -> &'static str {
    match head {
        "paper T" => "triangles of the paper's model",
        "paper L/T" | "L/T" => "links per triangle",
        "paper fly" => "the paper's time of a frame on the fly, as a multiple of its first row's",
        "paper incr" => "the paper's time in mode incremental, likewise",
        "incr" => "time of a frame of mode incremental after a bump moved on 1 % of the triangles, likewise",
        "sample ms" => "time with one sample for every cluster, as a multiple of the row's own time",
        "sample L2" => "L2 error with one sample for every cluster",
        "sample p99" => "99th percentile of the error with one sample for every cluster",
        "paper render" => "the paper's time in mode render, as a multiple of the first on-the-fly time",
        "paper ratio" => "the paper's time of the first kind over the second",
        "T" => "triangles",
        "fly" => "time of a frame on the fly, as a multiple of our first row's",
        "render" => "time in mode render, as a multiple of the first on-the-fly time",
        "ratio" => "time of the first kind over the second",
        "L2" | "exact L2" | "sampled L2" => "relative L2 error of the radiosity against f64, worst channel",
        "p99" | "exact p99" | "sampled p99" => "99th percentile of the error over the rms, worst channel",
        "paper ms/L" | "ms/L" => "time per link, as a multiple of the first row's",
        "paper" => "the paper's model",
        "paper tree" => "the paper's hierarchy",
        "ours" => "the shape or mesh in its place",
        "meters" => "extent of the object, metres",
        "paper exact" | "exact" => "time with form factors, as a multiple of the first row's",
        "paper sampled" | "sampled" => "time with point samples, as a multiple of the first row with form factors",
        "near/T" => "near links per triangle: those that are not a single sample",
        "samples" => "point samples per near link",
        "alone" => "the ratio for the time of the form factors alone",
        _ => "",
    }
}

/// Adds all points as a file.
fn csv(page: &mut Page, name: &str, place: &str, points: &[Point]) -> Result<()> {
    let columns = [
        ("channel", ""),
        (place, "distance of the receiver, mm"),
        ("F", "the form factor, to nearly all digits"),
        ("paper_segments", "segments that the published method takes per source"),
        ("paper_error", "its relative error"),
        ("ours_1e-2_error", "relative error of our rule at a tolerance of 1e-2"),
        ("ours_1e-4_error", "the same at 1e-4"),
        ("sample_scatter", "standard deviation of a single uniform sample, relative to F"),
        ("discs", "samples that the criterion of Jensen and Buhler asks for"),
    ];
    let row = |p: &Point| {
        let mut row = vec![NAMES[p.channel].to_string(), format!("{:.6}", p.place), format!("{:.9e}", p.exact)];
        row.push((p.paper.segments / 2).to_string());
        row.extend([p.error(p.paper.value), p.error(p.ours[0].1), p.error(p.ours[1].1)].map(|x| format!("{x:.3e}")));
        row.extend([format!("{:.4}", p.scatter), p.discs.to_string()]);
        row
    };
    page.fold("All points", |page| page.table(name, &columns, &points.iter().map(row).collect::<Vec<_>>()))
}
