//! Tables 3, 4, 5 and figure 5, told row by row as they are measured.

use super::models::{angle, at_angle, mesh, shape, split};
use super::paper::{EXTENT_3, EXTENT_4, FIGURE_5, TABLE_3, TABLE_4, TABLE_5};
use super::solve::{Kept, Solved};
use super::{Bench, Beside, Tell};
use crate::error::Result;
use crate::measure::norms::Norms;
use crate::measure::table::Table;
use crate::scene::{ClusterForm, Near, Scene};

/// How often the base is split at most, for table 3's first row and for the subdivided models of table 4.
const LEVELS_3: usize = 2;
const LEVELS_4: usize = 3;
/// Triangles of the built-in shape for table 5.
const FACES_5: usize = 4474;

fn error(norms: Norms) -> [String; 2] {
    [norms.l2, norms.p99].map(|x| format!("{x:.1e}"))
}

fn cells<const N: usize>(values: [f64; N]) -> [String; N] {
    values.map(|x| format!("{x:.2}"))
}

/// The paper's number of links per triangle.
fn density(faces: usize, kilolinks: f64) -> f64 {
    1e3 * kilolinks / faces as f64
}

/// Exponent of growth from the first row to the last, as a power of the number of triangles.
fn power(faces: [f64; 2], values: [f64; 2]) -> f64 {
    (values[1] / values[0]).ln() / (faces[1] / faces[0]).ln()
}

const L2: &str = "relative L2 error of the radiosity against f64, worst channel";
const P99: &str = "99th percentile of the error over the rms, worst channel";
const TRIANGLES: &str = "triangles of the paper's model";
const LINKS: &str = "links per triangle";

/// The columns of table 3.
const COLUMNS_3: [(&str, &str); 14] = [
    ("paper T", TRIANGLES),
    ("paper L/T", LINKS),
    ("paper fly", "the paper's time of a frame on the fly, as a multiple of its first row's"),
    ("paper incr", "the paper's time in mode incremental, likewise"),
    ("paper render", "the paper's time in mode render, as a multiple of the first on-the-fly time"),
    ("paper ratio", "the paper's time on the fly over that in mode render"),
    ("T", "triangles"),
    ("L/T", LINKS),
    ("fly", "time of a frame on the fly, as a multiple of our first row's"),
    ("incr", "time of a frame of mode incremental after a bump moved on 1 % of the triangles, likewise"),
    ("render", "time in mode render, as a multiple of the first on-the-fly time"),
    ("ratio", "time on the fly over that in mode render"),
    ("L2", L2),
    ("p99", P99),
];

/// The columns of table 4.
const COLUMNS_4: [(&str, &str); 14] = [
    ("paper", "the paper's model"),
    ("paper tree", "the paper's hierarchy"),
    ("paper T", TRIANGLES),
    ("paper L/T", LINKS),
    ("paper ms/L", "time per link, as a multiple of the first row's"),
    ("ours", "the shape or mesh in its place"),
    ("T", "triangles"),
    ("L/T", LINKS),
    ("ms/L", "time per link, as a multiple of the first row's"),
    ("L2", L2),
    ("p99", P99),
    ("sample ms", "time with one sample for every cluster, as a multiple of the row's own time"),
    ("sample L2", "L2 error with one sample for every cluster"),
    ("sample p99", "99th percentile of the error with one sample for every cluster"),
];

/// The columns of table 5.
const COLUMNS_5: [(&str, &str); 14] = [
    ("meters", "extent of the object, metres"),
    ("paper exact", "time with form factors, as a multiple of the first row's"),
    ("paper sampled", "time with point samples, as a multiple of the first row with form factors"),
    ("paper ratio", "the paper's time with point samples over that with form factors"),
    ("near/T", "near links per triangle: those that are not a single sample"),
    ("samples", "point samples per near link"),
    ("exact", "time with form factors, as a multiple of the first row's"),
    ("sampled", "time with point samples, as a multiple of the first row with form factors"),
    ("ratio", "time with point samples over that with form factors"),
    ("alone", "the ratio for the time of the form factors alone"),
    ("exact L2", L2),
    ("exact p99", P99),
    ("sampled L2", L2),
    ("sampled p99", P99),
];

impl Beside {
    fn new(name: impl Into<String>, before: &[&str], columns: &[(&str, &str)]) -> Self {
        let table = Table::new(columns.iter().copied(), Vec::new());
        Self { name: name.into(), before: before.iter().map(ToString::to_string).collect(), table, after: Vec::new() }
    }
}

/// Table 3: links and times by number of triangles.
pub fn table_3(bench: &Bench<'_>, tell: Tell<'_>) -> Result<Vec<Beside>> {
    let about = "Table 3: triangles T against links L and time; marble, 2.5 cm. Times as multiples of the first row's \
                 on-the-fly.";
    let mut found = Vec::new();
    for name in ["sphere", "lotus"] {
        let first = split(name, TABLE_3[0].faces, LEVELS_3, EXTENT_3)?;
        let both = angle(&first, bench.device, density(TABLE_3[0].faces, TABLE_3[0].kilolinks))?;
        let model = format!(
            "{name}, a butterfly subdivision as in the paper; both solid angles {both:.3}, for the paper's L/T in the \
             first row; incremental: a bump moves 1 % of the triangles, the paper does not say what changes"
        );
        let mut beside = Beside::new(format!("table-3-{name}"), &[about, &model], &COLUMNS_3);
        let mut ours: Vec<[f64; 5]> = Vec::new();
        for (level, row) in (LEVELS_3..).zip(&TABLE_3).filter(|(_, row)| row.faces <= bench.most_faces) {
            let scene = at_angle(&split(name, row.faces, level, EXTENT_3)?, both);
            let mut fly = Solved::new(&scene, bench.device, Kept::Nothing)?;
            let time = fly.time()?;
            let kept = |kept: Kept| match Solved::if_it_fits(&scene, bench.device, kept)? {
                Some(mut kept) => kept.time(),
                None => Ok(f64::NAN),
            };
            let (altered, render) = (kept(Kept::Altered)?, kept(Kept::Links)?);
            ours.push([fly.faces() as f64, fly.links() as f64, time, render, altered]);
            let (unit, base) = (ours[0][2], TABLE_3[0].ms[0]);
            let [flies, changes, renders] = row.ms.map(|ms| ms / base);
            let paper = [density(row.faces, row.kilolinks), flies, changes, renders, flies / renders];
            let own = [fly.links_per_face(), time / unit, altered / unit, render / unit, time / render];
            let mut line = vec![row.faces.to_string()];
            line.extend(cells(paper));
            line.push(fly.faces().to_string());
            line.extend(cells(own));
            line.extend(error(fly.error(&fly.truth(bench.samples))));
            beside.table.rows.push(line);
            tell(&beside)?;
        }
        if let ([a, .., b], Some(last)) = (&ours[..], TABLE_3.get(ours.len() - 1)) {
            let (first, grow) = (&TABLE_3[0], |k: usize| power([a[0], b[0]], [a[k], b[k]]));
            let paper = |f: &dyn Fn(&super::paper::Complexity) -> f64| {
                power([first.faces as f64, last.faces as f64], [f(first), f(last)])
            };
            beside.after.push(format!(
                "powers of T, paper / ours: links {:.2} / {:.2}, on-the-fly {:.2} / {:.2}, render {:.2} / {:.2}; \
                 incremental {:.2} / {:.2}",
                paper(&|r| r.kilolinks),
                grow(1),
                paper(&|r| r.ms[0]),
                grow(2),
                paper(&|r| r.ms[2]),
                grow(3),
                paper(&|r| r.ms[1]),
                grow(4)
            ));
        }
        found.push(beside);
    }
    Ok(found)
}

/// Table 4: several models at one setting.
pub fn table_4(bench: &Bench<'_>, tell: Tell<'_>) -> Result<Vec<Beside>> {
    let first = &TABLE_4[0];
    let start = shape(first.stand_in, first.faces, EXTENT_4)?;
    let both = angle(&start, bench.device, density(first.faces, first.kilolinks))?;
    let about =
        "Table 4: models at one conservative setting; marble, 10 cm. Time a link as a multiple of the first row's.";
    let angles = format!(
        "both solid angles {both:.3}, for the paper's L/T in the first row; trees as in the paper: FC face clusters, S \
         butterfly subdivision; the last columns: one sample for every cluster, its time as a multiple of the row's own"
    );
    let mut beside = Beside::new("table-4", &[about, &angles], &COLUMNS_4);
    let mut unit = None;
    let mut ours = |scene: &Scene| -> Result<Vec<String>> {
        let mut solved = Solved::new(&at_angle(scene, both), bench.device, Kept::Nothing)?;
        let time = solved.time()?;
        let each = time / solved.links() as f64;
        let (relative, links) = (each / *unit.get_or_insert(each), solved.links_per_face());
        // The same links, with one sample for every cluster.
        let mut sampled = at_angle(scene, both);
        sampled.transport.cluster = Some(ClusterForm::Sample);
        let mut sampled = Solved::new(&sampled, bench.device, Kept::Nothing)?;
        let truth = solved.truth(bench.samples);
        let mut line = vec![scene.name.clone(), solved.faces().to_string()];
        line.extend(cells([links, relative]));
        line.extend(error(solved.error(&truth)));
        line.extend(cells([sampled.time()? / time]));
        line.extend(error(sampled.error(&truth)));
        Ok(line)
    };
    for row in TABLE_4.iter().filter(|row| row.faces <= bench.most_faces) {
        let mut line = vec![row.name.to_string(), row.hierarchy.to_string(), row.faces.to_string()];
        let relative = row.ms / row.kilolinks / (first.ms / first.kilolinks);
        line.extend(cells([density(row.faces, row.kilolinks), relative]));
        let scene = match row.hierarchy {
            "S" => split(row.stand_in, row.faces, LEVELS_4, EXTENT_4)?,
            _ => shape(row.stand_in, row.faces, EXTENT_4)?,
        };
        line.extend(ours(&scene)?);
        beside.table.rows.push(line);
        tell(&beside)?;
    }
    for path in bench.meshes {
        beside.table.rows.push([vec!["-".into(); 5], ours(&mesh(path, EXTENT_4)?)?].concat());
        tell(&beside)?;
    }
    Ok(vec![beside])
}

/// Table 5: the edge form against point samples; figure 5: the noise of point samples.
pub fn table_5(bench: &Bench<'_>, tell: Tell<'_>) -> Result<Vec<Beside>> {
    let first = &TABLE_4[0];
    let start = shape("slab", FACES_5.min(bench.most_faces), EXTENT_4)?;
    let both = angle(&start, bench.device, density(first.faces, first.kilolinks))?;
    let slab = |extent: f64| shape("slab", FACES_5.min(bench.most_faces), extent);
    let mut found = vec![table_5_of(bench, tell, ("table-5", "slab"), both, &slab)?];
    for (number, path) in (1..).zip(bench.meshes) {
        let name = format!("table-5-mesh-{number}");
        found.push(table_5_of(bench, tell, (&name, path), both, &|extent| mesh(path, extent))?);
    }
    Ok(found)
}

fn table_5_of(
    bench: &Bench<'_>,
    tell: Tell<'_>,
    (table, model): (&str, &str),
    both: f64,
    make: &dyn Fn(f64) -> Result<Scene>,
) -> Result<Beside> {
    let about =
        "Table 5: near triangles by the edge form (\"exact\") against uniform point samples; marble, on the fly.";
    let angles = format!(
        "{model}: both solid angles {both:.3}, for the L/T of table 4's first row; times as multiples of the first exact one"
    );
    let mut beside = Beside::new(table, &[about, &angles], &COLUMNS_5);
    let mut unit = None;
    let mut picture = None;
    for row in &TABLE_5 {
        let mut scene = at_angle(&make(1e3 * row.meters)?, both);
        let mut exact = Solved::new(&scene, bench.device, Kept::Nothing)?;
        scene.transport.near = Near::PointSampling;
        let mut sampled = Solved::new(&scene, bench.device, Kept::Nothing)?;
        let [[a, form], [b, points]] = exact.time_beside(&mut sampled)?;
        let unit = *unit.get_or_insert(a);
        let (near, base) = (exact.near_links() as f64 / exact.faces() as f64, TABLE_5[0].ms[0]);
        let truth = exact.truth(bench.samples);
        let (precise, rough) = (exact.error(&truth), sampled.error(&truth));
        let paper = [row.meters, row.ms[0] / base, row.ms[1] / base, row.ms[1] / row.ms[0]];
        let own = [near, sampled.samples(), a / unit, b / unit, b / a, points / form];
        beside.table.rows.push([&cells(paper)[..], &cells(own), &error(precise), &error(rough)].concat());
        tell(&beside)?;
        if row.meters == FIGURE_5 {
            picture = Some((exact.faces(), precise, rough, sampled.noise(&exact)));
        }
    }
    if let Some((faces, precise, rough, [noise, averaged])) = picture {
        beside.after.push(format!(
            "Figure 5: marble, 20 cm, {model}, {faces} triangles. Paper: low frequency noise is clearly visible with point \
             sampling. Ours: largest error of the rms {:.1e} by the edge form, {:.1e} by point samples; the samples' noise \
             is {noise:.1e} of the rms on faces and {averaged:.1e} averaged at vertices, as a picture shows it",
            precise.max, rough.max
        ));
    }
    Ok(beside)
}
