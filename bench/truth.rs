//! `cargo bench --bench truth -- spot.obj horse.obj`: error against a random walk and against the area integral of the
//! same model, by run time, for the built-in ball, torus and slab and these meshes (20 mm across), in three materials:
//! `truth.csv` and the chart `truth.svg`. With `truth.csv` as the only argument, the chart alone is drawn again.
//!
//! `--seconds 8` is how long each walk takes, `--budget 15` what a point may take, `--methods blocks,octree` what is
//! compared.

use std::fmt::Write as _;
use std::path::Path;

use milkglass::error::{Error, Input, Result};
use milkglass::internals::session::walk::WalkControl;
use milkglass::measure::pareto::{Bench, Lighting, METHODS, Settings, sweep};
use milkglass::measure::truth::Truth;
use milkglass::{Device, Scene};

/// What is built in: names, scenes, and what is set.
const SHAPES: [(&str, &str, &[&str]); 3] = [
    ("ball, 20 mm", "sphere", &["object.0.size=20"]),
    ("torus, 36 mm", "torus", &["object.0.deform=[]"]),
    ("slab, 10 x 10 x 2 mm", "slab", &["object.0.size=10"]),
];
const MATERIALS: [&str; 3] = ["marble", "wholemilk", "skin1"];
const LIGHT: &str = "light=[{ type = 'directional', direction = [0.6, 0.7, 0.4], irradiance = 3 }]";
/// Those of [`METHODS`] that are compared unless the command line says otherwise.
const COMPARED: &str = "blocks,links,octree,diffusion";
const HEADER: [&str; 8] = ["shape", "material", "method", "setting", "wall_ms", "truth_l2", "total_l2", "truth_noise"];

/// Size of a panel within its axes, the space around it, and the space above and below all, pixels.
const PANEL: [f64; 2] = [176.0, 150.0];
const GAP: [f64; 2] = [14.0, 14.0];
const LEFT: f64 = 66.0;
const TOP: f64 = 64.0;
const BELOW: f64 = 76.0;
/// Colours and names of the methods' curves (Okabe and Ito).
const CURVES: [(&str, &str); 4] =
    [("blocks", "#0072b2"), ("links", "#d55e00"), ("octree", "#009e73"), ("diffusion", "#cc79a7")];

/// A measured point.
struct Row {
    words: [String; 4],
    /// Milliseconds, errors against the walk and the area integral, and the walk's noise.
    numbers: [f64; 4],
}

fn main() -> Result<()> {
    let (mut seconds, mut budget, mut methods) = (8.0, 15.0, COMPARED.to_string());
    let (mut files, mut words) = (Vec::new(), std::env::args().skip(1).filter(|word| word != "--bench"));
    let number = |word: Option<String>| {
        let value = word.as_deref().and_then(|word| word.parse().ok()).filter(|x: &f64| x.is_finite() && *x > 0.0);
        value.ok_or_else(|| Input::new("expected seconds, above 0").key("--seconds, --budget"))
    };
    while let Some(word) = words.next() {
        match word.as_str() {
            "--seconds" => seconds = number(words.next())?,
            "--budget" => budget = number(words.next())?,
            "--methods" => methods = words.next().unwrap_or_default(),
            _ => files.push(word),
        }
    }
    let rows = match files.as_slice() {
        [file] if file.ends_with(".csv") => read(file)?,
        _ => {
            let rows = measure(&files, seconds, budget, &methods)?;
            save("truth.csv", &csv(&rows))?;
            rows
        }
    };
    save("truth.svg", &svg(&rows))
}

fn save(file: &str, text: &str) -> Result<()> {
    std::fs::write(file, text)
        .map_err(|error| Input::new("could not be written").file(Path::new(file)).found(error).into())
}

/// Measures everything, one line of progress a panel.
fn measure(files: &[String], seconds: f64, budget: f64, methods: &str) -> Result<Vec<Row>> {
    let device = Device::best()?;
    let known = methods.split(',').filter_map(|name| METHODS.iter().find(|method| method.name == name)).collect();
    let mut settings = Settings { methods: known, values: 5, repeat: 3, samples: 60, seed: 1, budget, truth: None };
    let stem = |file: &str| Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let own = files.iter().map(|file| (format!("{}, 20 mm", stem(file)), file.clone(), &["object.0.size=20"][..]));
    let built_in = SHAPES.iter().map(|(name, scene, sets)| ((*name).to_string(), (*scene).to_string(), *sets));
    let mut rows = Vec::new();
    for (shape, scene, sets) in built_in.chain(own) {
        for material in MATERIALS {
            let material_set = format!("object.0.material={{ preset = '{material}' }}");
            let sets: Vec<String> =
                sets.iter().chain(&[LIGHT, material_set.as_str()]).map(ToString::to_string).collect();
            let scene = Scene::load_with(&scene, &sets)?;
            let bench = Bench { scene: &scene, device: device.as_ref() };
            settings.truth =
                Some(Truth::find(&format!("walk:{seconds}"), &scene, bench.device, WalkControl::default())?);
            let found = sweep(&bench, &settings)?;
            let before = rows.len();
            for (point, run) in found.measured(Lighting::Moves) {
                let Some(truth) = run.truth else { continue };
                let words = [&shape, material, point.method.name, &point.value.to_string()].map(ToString::to_string);
                rows.push(Row { words, numbers: [run.wall_ms, truth.norms().l2, run.total.l2, truth.noise] });
            }
            println!(
                "{shape}, {material}: {} points, {}",
                rows.len() - before,
                settings.truth.as_ref().map_or("", |t| &t.about)
            );
        }
    }
    Ok(rows)
}

fn csv(rows: &[Row]) -> String {
    let line = |row: &Row| {
        let words = row.words.iter().map(|word| format!("\"{word}\""));
        words.chain(row.numbers.iter().map(|x| format!("{x:.4e}"))).collect::<Vec<_>>().join(",") + "\n"
    };
    HEADER.join(",") + "\n" + &rows.iter().map(line).collect::<String>()
}

fn read(file: &str) -> Result<Vec<Row>> {
    let fault = |error: csv::Error| Error::from(Input::new("not such a table").file(Path::new(file)).found(error));
    let mut reader = csv::Reader::from_path(file).map_err(fault)?;
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(fault)?;
        let cell = |k: usize| record.get(k).unwrap_or_default().to_string();
        let number = |k: usize| cell(k).parse().unwrap_or(f64::NAN);
        rows.push(Row { words: [0, 1, 2, 3].map(cell), numbers: [4, 5, 6, 7].map(number) });
    }
    Ok(rows)
}

/// A logarithmic axis: powers of ten, pixels from the first to the second.
struct Axis([f64; 2], [f64; 2]);

impl Axis {
    /// Around these numbers.
    fn around(numbers: impl Iterator<Item = f64>, pixels: f64) -> Self {
        let finite = numbers.filter(|x| x.is_finite() && *x > 0.0).map(f64::log10);
        let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        Self([low - 0.15, high + 0.15], [0.0, pixels])
    }

    fn at(&self, x: f64) -> f64 {
        let Self([low, high], [first, last]) = self;
        first + (last - first) * ((x.log10() - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// The powers of ten on it.
    fn decades(&self) -> impl Iterator<Item = f64> {
        (self.0[0].ceil() as i32..=self.0[1].floor() as i32).map(|power| 10f64.powi(power))
    }
}

/// A duration in few letters, from milliseconds.
fn time(ms: f64) -> String {
    if ms < 1000.0 { format!("{ms} ms") } else { format!("{} s", ms / 1000.0) }
}

/// Each of them once, in order.
fn once(words: impl Iterator<Item = String>) -> Vec<String> {
    let mut list = Vec::new();
    words.for_each(|word| {
        if !list.contains(&word) {
            list.push(word)
        }
    });
    list
}

/// The chart: a column for each shape, a row for each material.
fn svg(rows: &[Row]) -> String {
    let (shapes, materials) =
        (once(rows.iter().map(|row| row.words[0].clone())), once(rows.iter().map(|row| row.words[1].clone())));
    let x = Axis::around(rows.iter().map(|row| row.numbers[0]), PANEL[0]);
    let y = Axis::around(rows.iter().flat_map(|row| [row.numbers[1], row.numbers[2].max(3e-4)]), PANEL[1]);
    let (width, height) =
        (LEFT + shapes.len() as f64 * (PANEL[0] + GAP[0]), TOP + materials.len() as f64 * (PANEL[1] + GAP[1]) + BELOW);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#282828\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <text x=\"{LEFT}\" y=\"24\" font-size=\"16\">Relative L2 error of radiosity against time per frame, light \
         moving</text>\n"
    );
    for (column, shape) in shapes.iter().enumerate() {
        for (line, material) in materials.iter().enumerate() {
            let corner = [LEFT + column as f64 * (PANEL[0] + GAP[0]), TOP + line as f64 * (PANEL[1] + GAP[1])];
            let _ = writeln!(out, "<g transform=\"translate({},{})\">", corner[0], corner[1]);
            if line == 0 {
                let _ = writeln!(out, "<text x=\"{}\" y=\"-8\" text-anchor=\"middle\">{shape}</text>", PANEL[0] / 2.0);
            }
            let own: Vec<&Row> = rows.iter().filter(|r| r.words[0] == *shape && r.words[1] == *material).collect();
            panel(&mut out, &own, &x, &y, (column == 0).then_some(material), line + 1 == materials.len());
            out += "</g>\n";
        }
    }
    legend(&mut out, rows, height - BELOW + 40.0);
    out + "</svg>\n"
}

/// One panel: the grid, the walk's noise, and each method's curves.
fn panel(out: &mut String, rows: &[&Row], x: &Axis, y: &Axis, left: Option<&String>, last: bool) {
    let [w, h] = PANEL;
    for decade in x.decades() {
        let at = x.at(decade).round();
        let _ = writeln!(out, "<path d=\"M{at} 0V{h}\" stroke=\"#ddd\"/>");
        if last {
            let _ = writeln!(out, "<text x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{}</text>", h + 16.0, time(decade));
        }
    }
    for decade in y.decades() {
        let at = (h - y.at(decade)).round();
        let _ = writeln!(out, "<path d=\"M0 {at}H{w}\" stroke=\"#ddd\"/>");
        if left.is_some() {
            let percent = 100.0 * decade;
            let _ = writeln!(out, "<text x=\"-6\" y=\"{}\" text-anchor=\"end\">{percent} %</text>", at + 4.0);
        }
    }
    if let Some(material) = left {
        let _ = writeln!(
            out,
            "<text transform=\"translate(-50,{}) rotate(-90)\" text-anchor=\"middle\" font-size=\"14\">{material}</text>",
            h / 2.0
        );
    }
    let noise = rows.first().map_or(f64::NAN, |row| row.numbers[3]);
    if noise.is_finite() && noise > 0.0 {
        let at = (h - y.at(noise)).round();
        let _ = writeln!(out, "<path d=\"M0 {at}H{w}\" stroke=\"#777\" stroke-dasharray=\"1 3\"/>");
    }
    let _ = writeln!(out, "<rect width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"#999\"/>");
    for (name, color) in CURVES {
        let dots = |of: usize| -> Vec<String> {
            let own = rows.iter().filter(|row| row.words[2] == name && row.numbers[of].is_finite());
            own.map(|row| format!("{:.1} {:.1}", x.at(row.numbers[0]), h - y.at(row.numbers[of]))).collect()
        };
        let (truth, total) = (dots(1), dots(2));
        if truth.is_empty() {
            continue;
        }
        let _ = writeln!(
            out,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-dasharray=\"4 3\" opacity=\".75\"/>\n\
             <path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            total.join("L"),
            truth.join("L")
        );
        for dot in &truth {
            let (cx, cy) = dot.split_once(' ').unwrap_or_default();
            let _ = writeln!(out, "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"2.6\" fill=\"{color}\"/>");
        }
    }
}

/// What colours and strokes mean.
fn legend(out: &mut String, rows: &[Row], top: f64) {
    let mut at = LEFT;
    for (name, color) in CURVES.iter().filter(|(name, _)| rows.iter().any(|row| row.words[2] == *name)) {
        let _ = writeln!(
            out,
            "<path d=\"M{at} {top}h24\" stroke=\"{color}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            at + 30.0,
            top + 4.0
        );
        at += 54.0 + 8.0 * name.len() as f64;
    }
    let strokes = [
        ("stroke-width=\"2\" stroke=\"#444\"", "against a random walk, over patches, worst channel, noise taken off"),
        ("stroke-dasharray=\"4 3\" stroke=\"#444\"", "against the same model, summed exactly"),
        ("stroke-dasharray=\"1 3\" stroke=\"#777\"", "the walk's noise"),
    ];
    let (mut at, top) = (LEFT, top + 22.0);
    for (stroke, words) in strokes {
        let _ = writeln!(
            out,
            "<path d=\"M{at} {top}h24\" {stroke}/><text x=\"{}\" y=\"{}\">{words}</text>",
            at + 30.0,
            top + 4.0
        );
        at += 54.0 + 6.6 * words.len() as f64;
    }
}
