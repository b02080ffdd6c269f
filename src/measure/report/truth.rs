//! Section `truth`: how far each method is from the random walk, whatever its tolerance: the model's error and all
//! others, beside the time.

use super::pictures::Shot;
use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::table::Table;
use crate::measure::truth::{Truth, TruthError};
use crate::measure::validity::places;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::run::Session;

/// A shape: its caption, its name in scenes, cells for a full and a quick report, and a factor on the thickness.
type Shape = (&'static str, &'static str, [u32; 2], f64);
const SHAPES: [Shape; 3] = [
    ("ball, 20 mm", "sphere", [4, 3], 1.0),
    ("torus, 20 mm", "torus", [60, 36], 1.0),
    ("slab, 20 x 20 x 2 mm", "slab", [40, 24], 0.5),
];

/// Settings of all shapes: 20 mm, one light that reaches two sides of the slab, and a camera that sees both.
const COMMON: [&str; 4] = [
    "object.0.size=20",
    "light=[{ type = 'directional', direction = [0.5, 0.3, 0.8], irradiance = 3 }]",
    "camera.position=[-18, 14, 52]",
    "camera.fov=30",
];

/// The materials.
const MATERIALS: [&str; 3] = ["marble", "wholemilk", "skin1"];

/// A method's name, its transport, and whether its picture is shown.
const METHODS: [(&str, ShadingMethod, bool); 4] = [
    ("dipole", ShadingMethod::Hierarchy, true),
    ("diffusion", ShadingMethod::Diffusion, true),
    ("CDRF", ShadingMethod::Cdrf, true),
    ("Lambert", ShadingMethod::Lambert, false),
];

/// The columns of the table: names, and what they mean.
const COLUMNS: [(&str, &str); 11] = [
    ("shape", ""),
    ("material", ""),
    ("method", ""),
    ("red %", "relative L2 error against the walk, the walk's noise taken off"),
    ("green %", "the same"),
    ("blue %", "the same"),
    ("FLIP", "perceptual difference of the pictures, 0 to 1; the walk's noise counts"),
    ("frame, ms", "a frame from scratch on the device"),
    ("walk's noise %", "relative L2 of the walk's standard errors over the same patches, worst channel"),
    ("photons", "of the walk, each channel"),
    ("walk, s", "time of the walk"),
];

/// Radiosity of every triangle by a method, in the mesh's order, the picture and the milliseconds of a frame.
fn solved(scene: &Scene, bench: &Bench<'_>, method: ShadingMethod) -> Result<(Vec<[f64; 3]>, Shot)> {
    let mut session = Session::new(scene, bench.device, Options { transport: method, ..Options::default() })?;
    session.frame(Change::EVERYTHING)?;
    // The first frame makes lists and buffers; the next one is timed.
    let times = session.frame(Change::EVERYTHING)?;
    let shot = Shot::of(&session.picture()?, times.iter().map(|time| time.milliseconds).sum());
    if matches!(method, ShadingMethod::Hierarchy | ShadingMethod::Diffusion) {
        return Ok((session.faces()?.into_iter().map(|face| face.radiosity).collect(), shot));
    }
    let mut found = vec![[0.0; 3]; scene.objects[0].mesh.triangles.len()];
    for place in places(scene, bench.device)? {
        let value = if method == ShadingMethod::Cdrf { place.cdrf } else { place.lambert };
        found[place.triangle as usize][place.channel] = value;
    }
    Ok((found, shot))
}

/// All shapes in all materials; a quick report has marble only, and walks of fewer photons.
pub fn truth(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say(
        "The random walk (--transport walk) makes none of the models' approximations. Errors are relative L2 of the radiosity's \
         means over some 200 patches, with the walk's own noise taken off: what is left is the model's error, and no tolerance \
         makes it smaller. Times are those of a frame from scratch.",
    );
    let effort = bench.either("transport.walks=12000", "transport.walk_error=0.04");
    compare(bench, page, &SHAPES, bench.either(120, 240), effort)
}

/// Walks through these shapes with this effort, and compares all methods with the walks; pictures have `side` pixels a
/// side.
fn compare(bench: &Bench<'_>, page: &mut Page, shapes: &[Shape], side: u32, effort: &str) -> Result<()> {
    let (mut rows, mut worst) = (Vec::new(), Vec::new());
    for &(shape, name, [full, quick], thinner) in shapes {
        for material in bench.either(&MATERIALS[..1], &MATERIALS[..]) {
            let own = [
                format!("camera.size=[{side}, {side}]"),
                "camera.samples=1".into(),
                format!("object.0.material={{ preset = '{material}' }}"),
                format!("object.0.shape={name}"),
                format!("object.0.detail={}", bench.either(quick, full)),
                effort.into(),
            ];
            let all = COMMON.iter().map(ToString::to_string).chain(own);
            let mut scene = Scene::load_with("sphere", &all.collect::<Vec<_>>())?;
            scene.objects[0].mesh.positions.iter_mut().for_each(|place| place.z *= thinner);
            let options = Options { transport: ShadingMethod::Walk, ..Options::default() };
            let mut session = Session::new(&scene, bench.device, options)?;
            session.frame(Change::EVERYTHING)?;
            let reference = Shot::of(&session.picture()?, f64::NAN);
            let (walk, report) = (Truth::of_session(&mut session)?, session.walk_reports()[0].clone());
            page.head(&format!("{shape}, {material}"));
            let mut shown = vec![reference.show(format!("random walk, {:.1} s", report.seconds))?];
            for (method, transport, pictured) in METHODS {
                let (found, shot) = solved(&scene, bench, transport)?;
                let TruthError { l2, noise } = walk.error(&found);
                let (flip, map) = shot.apart(&reference)?;
                if pictured {
                    shown.push(shot.show(format!("{method}, {:.1} ms", shot.ms))?);
                    shown.push(map.show(format!("difference, FLIP {flip:.3}"))?);
                }
                if transport == ShadingMethod::Hierarchy {
                    worst.push((l2.into_iter().fold(0.0, f64::max), shape, material));
                }
                let mut row = vec![shape.to_string(), (*material).to_string(), method.to_string()];
                row.extend(l2.map(|error| format!("{:.1}", 100.0 * error)));
                row.extend([format!("{flip:.3}"), format!("{:.1}", shot.ms)]);
                row.extend([format!("{:.1}", 100.0 * noise), report.photons.to_string()]);
                row.push(format!("{:.2}", report.seconds));
                rows.push(row);
            }
            page.pictures(&shown);
        }
    }
    page.table("truth", &Table::new(COLUMNS, rows))?;
    for (error, shape, material) in worst {
        let aim = format!("{shape}, {material}: the dipole is within 5 % of a random walk");
        page.find(Tone::of(error <= 0.05), &aim, &format!("{:.1} %", 100.0 * error));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn each_method_has_its_errors_pictures_and_costs() {
        let (mut page, bench) = (Page::default(), Bench { quick: true, ..Bench::default() });
        let shapes = [("ball", "sphere", [2, 2], 1.0), ("disc", "sphere", [1, 1], 0.5)];
        compare(&bench, &mut page, &shapes, 24, "transport.walks=30000").unwrap();
        let (name, table) = &page.files[0];
        assert_eq!((name.as_str(), page.files.len()), ("truth.csv", 1));
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(table.as_slice());
        let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.unwrap()).collect();
        let cell = |row: &csv::StringRecord, name: &str| {
            row[rows[0].iter().position(|n| n == name).unwrap()].parse::<f64>().unwrap()
        };
        let named: Vec<_> = rows[1..].iter().map(|row| [&row[0], &row[1], &row[2]]).collect();
        let methods = ["dipole", "diffusion", "CDRF", "Lambert"];
        let all = ["ball", "disc"].map(|shape| methods.map(|method| [shape, "marble", method]));
        assert_eq!(named, all.concat());
        for row in &rows[1..] {
            // Its noise, its photons and its time are the walk's, the same for all methods.
            assert_eq!(cell(row, "photons"), 30_000.0);
            assert!((1.0..15.0).contains(&cell(row, "walk's noise %")) && cell(row, "walk, s") > 0.0, "{row:?}");
            assert!(cell(row, "frame, ms") > 0.0 && (0.001..0.9).contains(&cell(row, "FLIP")), "{row:?}");
        }
        // Diffusion is nearer to the truth in every channel; on the disc what does not scatter sideways is farther.
        for channel in ["red %", "green %", "blue %"] {
            for shape in [0, 4] {
                let [dipole, diffusion] = [1, 2].map(|row| cell(&rows[shape + row], channel));
                assert!((2.0..25.0).contains(&dipole) && diffusion < 0.6 * dipole, "{rows:?}");
            }
            let [dipole, lambert] = [5, 8].map(|row| cell(&rows[row], channel));
            assert!(lambert > 1.2 * dipole, "{rows:?}");
        }
        // For each shape the walk, and three methods with their differences; one finding.
        let found: Vec<_> = page.findings.iter().map(|found| found.aim.as_str()).collect();
        assert!(found[0].starts_with("ball, marble: ") && found[1].starts_with("disc, marble: ") && found.len() == 2);
        assert!(page.findings.iter().all(|found| found.found.ends_with(" %")), "{:?}", page.findings);
        assert_eq!(page.body().matches("<img").count(), 2 * 7);
        for word in ["ball, marble", "disc, marble", "random walk, ", "dipole, ", "CDRF, ", "difference, FLIP "] {
            assert!(page.body().contains(word), "{word}");
        }
    }
}
