//! A sweep as an SVG plot: error against wall-clock time on logarithmic axes, one column per lighting, one row per
//! reference of the error.

mod axes;

use axes::{Axes, Canvas, FAINT, INK, text};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::{Against, Lighting, Method, Origin, Sweep, mark};
use crate::error::{Error, Result};

/// Size of a panel, pixels.
const PANEL: [i32; 2] = [600, 440];
/// Height of the title above the panels, pixels.
const TITLE: i32 = 76;
/// Height of the legend below them, pixels: two rows of methods, and one for the front.
const LEGEND: i32 = 84;
/// Colour of the band along the front.
const BAND: RGBColor = RGBColor(222, 222, 222);
/// A palette for colour-blind readers (Okabe and Ito).
pub(in crate::measure) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// One point of a curve: time in milliseconds and L2, whether it is on the front, and its setting.
struct Dot {
    place: (f64, f64),
    front: bool,
    label: String,
}

/// One method in one panel.
struct Curve {
    style: usize,
    dots: Vec<Dot>,
}

/// Draws the plot.
pub fn svg(sweep: &Sweep, origin: &Origin) -> Result<String> {
    let lost = |error: &dyn std::fmt::Display| Error::Check(format!("the plot could not be drawn: {error}"));
    let rows = sweep.plotted();
    let (width, height) = (2 * PANEL[0], TITLE + PANEL[1] * rows.len() as i32 + LEGEND);
    let mut picture = String::new();
    {
        let root = SVGBackend::with_string(&mut picture, (width as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE).map_err(|e| lost(&e))?;
        title(&root, sweep, origin).map_err(|e| lost(&e))?;

        // All panels share their axes, so that they can be compared.
        let panels: Vec<(usize, usize, Vec<Curve>)> = rows
            .iter()
            .enumerate()
            .flat_map(|(row, &against)| {
                let panel = move |(column, &lighting)| (row, column, curves(sweep, lighting, against));
                Lighting::ALL.iter().enumerate().map(panel)
            })
            .collect();
        let all = || panels.iter().flat_map(|(_, _, curves)| curves).flat_map(|curve| &curve.dots);
        let axes = Axes::around(all().map(|dot| dot.place));
        for (row, column, curves) in &panels {
            let corner = (*column as i32 * PANEL[0], TITLE + *row as i32 * PANEL[1]);
            let canvas = Canvas::new(&root, axes, corner, PANEL);
            canvas.frame(Lighting::ALL[*column].name(), rows[*row].name()).map_err(|e| lost(&e))?;
            panel(&canvas, curves).map_err(|e| lost(&e))?;
        }
        legend(&root, &sweep.methods(), height - LEGEND).map_err(|e| lost(&e))?;
        root.present().map_err(|e| lost(&e))?;
    }
    Ok(picture)
}

/// The curves of a panel, without points that do not fit on logarithmic axes.
fn curves(sweep: &Sweep, lighting: Lighting, against: Against) -> Vec<Curve> {
    let marks = mark(sweep, against);
    let of = |(style, method): (usize, &Method)| {
        let points = sweep.points.iter().zip(&marks);
        let own = points.filter(|(point, _)| point.lighting == lighting && point.method.name == method.name);
        let dot = |(point, &front): (&super::Point, &bool)| {
            let run = point.run.as_ref().ok()?;
            let place = (run.wall_ms, against.of(run).l2);
            let sound = place.0.is_finite() && place.1.is_finite() && place.0 > 0.0 && place.1 > 0.0;
            let label = if point.method.parameter.is_empty() { String::new() } else { point.value.to_string() };
            sound.then_some(Dot { place, front, label })
        };
        Curve { style, dots: own.filter_map(dot).collect() }
    };
    sweep.methods().into_iter().enumerate().map(of).collect()
}

/// Draws the front's band, the curves and their points.
fn panel<DB: DrawingBackend>(canvas: &Canvas<'_, DB>, curves: &[Curve]) -> axes::Drawn<DB> {
    let mut front: Vec<(f64, f64)> =
        curves.iter().flat_map(|curve| &curve.dots).filter(|dot| dot.front).map(|dot| dot.place).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A staircase: between two points nothing was measured, so the faster point's error holds until the slower one's
    // time.
    let steps = front.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    let band: Vec<_> = steps.chain(front.last().copied()).map(|place| canvas.at(place)).collect();
    canvas.root.draw(&PathElement::new(band, BAND.stroke_width(10)))?;
    for curve in curves {
        let line: Vec<_> = curve.dots.iter().map(|dot| canvas.at(dot.place)).collect();
        let style = COLORS[curve.style % COLORS.len()].stroke_width(2);
        canvas.root.draw(&PathElement::new(line, style))?;
    }
    for curve in curves {
        for dot in &curve.dots {
            let (x, y) = canvas.at(dot.place);
            marker(canvas.root, curve.style, (x, y), dot.front)?;
            text(canvas.root, &dot.label, (x + 8, y - 9), 11, &FAINT, HPos::Left)?;
        }
    }
    Ok(())
}

/// A method's marker: filled on the front, hollow off it.
fn marker<DB: DrawingBackend>(
    root: &DrawingArea<DB, plotters::coord::Shift>,
    style: usize,
    (x, y): (i32, i32),
    front: bool,
) -> axes::Drawn<DB> {
    let color = COLORS[style % COLORS.len()];
    let outline: Vec<(i32, i32)> = match style % 3 {
        0 => (0..24).map(|k| f64::from(k) * std::f64::consts::TAU / 24.0).map(|t| around((x, y), 5.5, t)).collect(),
        1 => vec![(x - 5, y - 5), (x + 5, y - 5), (x + 5, y + 5), (x - 5, y + 5)],
        _ => vec![(x, y - 7), (x + 7, y), (x, y + 7), (x - 7, y)],
    };
    root.draw(&Polygon::new(outline.clone(), if front { color.filled() } else { WHITE.filled() }))?;
    let closed = outline.iter().chain(outline.first()).copied().collect::<Vec<_>>();
    root.draw(&PathElement::new(closed, color.stroke_width(2)))
}

fn around((x, y): (i32, i32), radius: f64, angle: f64) -> (i32, i32) {
    (x + (radius * angle.cos()).round() as i32, y + (radius * angle.sin()).round() as i32)
}

/// The title: scene and material, device, and method of measurement.
fn title<DB: DrawingBackend>(
    root: &DrawingArea<DB, plotters::coord::Shift>,
    sweep: &Sweep,
    origin: &Origin,
) -> axes::Drawn<DB> {
    let Origin { scene, faces, extent_mm, material, device, driver, repeat, .. } = origin;
    let what = format!("{scene}: {faces} faces, {extent_mm} mm, {}", material.split(':').next().unwrap_or(material));
    let how = format!(
        "{device}, {driver}; median of {repeat} frames by the wall clock; errors of B at {} receivers, worst channel",
        sweep.samples
    );
    text(root, &what, (24, 26), 19, &INK, HPos::Left)?;
    text(root, &how, (24, 52), 13, &FAINT, HPos::Left)
}

/// The legend.
fn legend<DB: DrawingBackend>(
    root: &DrawingArea<DB, plotters::coord::Shift>,
    methods: &[&Method],
    top: i32,
) -> axes::Drawn<DB> {
    let (mut x, mut y) = (74, top + 24);
    for (style, method) in methods.iter().enumerate() {
        let parameter = if method.parameter.is_empty() { String::new() } else { format!(" ({})", method.parameter) };
        let name = format!("{}{parameter}", method.name);
        let width = 50 + 7 * name.len() as i32;
        if x + width > 2 * PANEL[0] {
            (x, y) = (74, y + 24);
        }
        let color = COLORS[style % COLORS.len()];
        root.draw(&PathElement::new(vec![(x - 16, y), (x + 16, y)], color.stroke_width(2)))?;
        marker(root, style, (x, y), true)?;
        text(root, &name, (x + 24, y), 13, &INK, HPos::Left)?;
        x += width + 30;
    }
    let (x, y) = (74, y + 24);
    root.draw(&PathElement::new(vec![(x - 16, y), (x + 16, y)], BAND.stroke_width(10)))?;
    text(root, "Pareto front; hollow marks are off it", (x + 24, y), 13, &INK, HPos::Left)
}

#[cfg(test)]
mod tests {
    use super::super::{Leaves, Opened, Point, Run};
    use super::*;
    use crate::measure::norms::Norms;
    use crate::measure::truth::TruthError;

    /// A method of which only the name matters.
    const fn method(name: &'static str, leaves: Leaves) -> Method {
        let open = |_: &super::super::Bench<'_>, _, _| Ok(Opened::NotOffered(String::new()));
        let equation = crate::measure::pareto::Equation::Dipole;
        Method { name, about: "", parameter: "threshold", values: &[0.1], equation, leaves, open, foretell: None }
    }

    static FINE: Method = method("fine", Leaves::Exact);
    static FAST: Method = method("fast", Leaves::Exact);
    static POINTS: Method = method("points", Leaves::Midpoint);

    fn origin() -> Origin {
        Origin {
            device: "device <1>".into(),
            driver: "driver".into(),
            scene: "ball".into(),
            faces: 80,
            extent_mm: 10.0,
            material: "Marble: much more".into(),
            repeat: 5,
        }
    }

    fn drawn(methods: &[&'static Method], walked: bool) -> String {
        let mut points = Vec::new();
        for (k, &method) in methods.iter().enumerate() {
            for (step, lighting) in [0, 1, 2, 3].into_iter().flat_map(|step| Lighting::ALL.map(|l| (step, l))) {
                let error = 0.1 * 0.3f64.powi(step);
                let norms = |l2: f64| Norms { l2, p99: 2.0 * l2, max: 5.0 * l2 };
                let wall_ms = 3.0 * 2.5f64.powi(step + k as i32);
                let (own, total) = (norms(error), norms(error.hypot(0.02 * k as f64)));
                let run = Run {
                    device_ms: None,
                    wall_ms,
                    range_ms: [wall_ms; 2],
                    busy: 1.0,
                    own,
                    total,
                    truth: walked.then(|| TruthError { l2: [error.hypot(0.1); 3], noise: 0.01 }),
                    links_per_face: None,
                };
                points.push(Point { method, value: 0.2 * 0.5f64.powi(step), lighting, run: Ok(run) });
            }
        }
        points.push(Point { method: methods[0], value: 0.0, lighting: Lighting::Moves, run: Err("too slow".into()) });
        let sweep = Sweep {
            points,
            samples: 9,
            midpoint: Norms { l2: 0.02, p99: 0.03, max: 0.1 },
            truth: walked.then(|| "a walk".into()),
        };
        svg(&sweep, &origin()).unwrap()
    }

    #[test]
    fn names_what_it_shows() {
        let picture = drawn(&[&FINE, &FAST], false);
        assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"));
        for words in
            ["light moves", "light rests", "time a frame, ms", "fine (threshold)", "fast", "Marble", "device &lt;1&gt;"]
        {
            assert!(picture.contains(words), "{words}");
        }
        assert!(picture.contains("its own leaf sums") && !picture.contains("the area integral"));
        assert!(!picture.contains("a random walk") && drawn(&[&FINE, &FAST], true).contains("a random walk"));
    }

    #[test]
    fn where_leaves_are_samples_the_area_integral_has_panels_too() {
        let picture = drawn(&[&FINE, &POINTS], false);
        assert!(picture.contains("its own leaf sums") && picture.contains("the area integral"));
    }

    #[test]
    fn nothing_measured_is_still_a_picture() {
        let sweep = Sweep { points: Vec::new(), samples: 1, midpoint: Norms::default(), truth: None };
        assert!(svg(&sweep, &origin()).unwrap().contains("light rests"));
    }
}
