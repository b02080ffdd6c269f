//! A sweep as an SVG plot: error against wall-clock time on logarithmic axes, one column per lighting, one row per
//! reference of the error.

use super::{Against, Lighting, Method, Origin, Sweep, mark};
use crate::error::Result;
use crate::measure::plot::{Axis, Mark, Panel, Plot, Point, Series};

/// Size of a panel, pixels.
const SIZE: [i32; 2] = [600, 440];

/// Draws the plot.
pub fn svg(sweep: &Sweep, origin: &Origin) -> Result<String> {
    let Origin { scene, faces, extent_mm, material, device, driver, repeat, .. } = origin;
    let title = [
        format!("{scene}: {faces} faces, {extent_mm} mm, {}", material.split(':').next().unwrap_or(material)),
        format!(
            "{device}, {driver}; median of {repeat} frames by the wall clock; errors of B at {} receivers, worst channel",
            sweep.samples
        ),
    ];
    let panel = |against: Against| Lighting::ALL.map(|lighting| panel(sweep, lighting, against));
    let panels = sweep.plotted().into_iter().flat_map(panel).collect();
    Plot { title: title.to_vec(), panels, columns: 2, shared: true }.svg()
}

/// The curves of all methods, and the band along the front.
fn panel(sweep: &Sweep, lighting: Lighting, against: Against) -> Panel {
    let marks = mark(sweep, against);
    let curve = |method: &Method| {
        let points = sweep.points.iter().zip(&marks);
        let own = points.filter(|(point, _)| point.lighting == lighting && point.method.name == method.name);
        let dot = |(point, &front): (&super::Point, &bool)| {
            let run = point.run.as_ref().ok()?;
            let label = if method.parameter.is_empty() { String::new() } else { point.value.to_string() };
            Some(Point { place: [run.wall_ms, against.of(run).l2], label, hollow: !front, ..Point::default() })
        };
        let parameter = if method.parameter.is_empty() { String::new() } else { format!(" ({})", method.parameter) };
        let name = format!("{}{parameter}", method.name);
        Series { points: own.filter_map(dot).collect(), ..Series::new(name, Mark::Curve, []) }
    };
    let mut series: Vec<Series> = sweep.methods().into_iter().map(curve).collect();
    let mut front: Vec<[f64; 2]> =
        series.iter().flat_map(|curve| &curve.points).filter(|point| !point.hollow).map(|point| point.place).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // A staircase: between two points nothing was measured, so the faster point's error holds until the slower one's
    // time.
    let steps = front.windows(2).flat_map(|pair| [pair[0], [pair[1][0], pair[0][1]]]);
    let band = steps.chain(front.last().copied()).map(|[ms, error]| (ms, error));
    series.push(Series::new("Pareto front; hollow marks are off it", Mark::Band, band.collect::<Vec<_>>()));
    let axes = [Axis::log("time a frame, ms"), Axis::log(&format!("L2 {}", against.name()))];
    Panel { size: SIZE, ..Panel::new(lighting.name(), axes, series) }
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
