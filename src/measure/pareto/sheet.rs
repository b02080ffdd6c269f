//! A sweep as CSV: one row per point, each complete in itself.

use super::{Against, Leaves, Sweep, mark};
use crate::error::{Error, Result};
use crate::measure::norms::Norms;
use crate::scene::{Material, Scene};

/// The origin of a sweep.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The device's name.
    pub device: String,
    /// Its driver and the driver's version.
    pub driver: String,
    /// The scene.
    pub scene: String,
    /// Its faces.
    pub faces: usize,
    /// Its largest extent, millimetres.
    pub extent_mm: f64,
    /// Its material.
    pub material: String,
    /// Timed frames per point.
    pub repeat: usize,
}

/// The largest extent in millimetres, rounded to six digits.
#[must_use]
pub fn extent_mm(scene: &Scene) -> f64 {
    let (low, high) = scene.bounds();
    let extent = (high - low).max_element() * scene.unit_mm;
    format!("{extent:.5e}").parse().unwrap_or(extent)
}

/// Names and coefficients per millimetre of all materials.
#[must_use]
pub fn materials(scene: &Scene) -> String {
    scene.objects.iter().map(|object| of_object(scene, &object.material)).collect::<Vec<_>>().join("; ")
}

fn of_object(scene: &Scene, material: &Material) -> String {
    if let Some(albedo) = material.opaque {
        return format!("opaque, albedo {albedo:?}");
    }
    let show = |values: [f64; 3]| values.map(|x| format!("{x:.4}")).join(" ");
    let per_mm = |values: [f64; 3]| show(values.map(|x| x / scene.unit_mm));
    let (scattering, absorption) = (per_mm(material.sigma_s_prime), per_mm(material.sigma_a));
    format!("{}: sigma_s' {scattering} /mm, sigma_a {absorption} /mm, eta {}", material.name, show(material.eta))
}

/// The columns; what is not known is empty. Times are medians in milliseconds; `wall_low_ms` and `wall_high_ms` are
/// the fastest and slowest frame, `busy` the time of a fixed job over its fastest time. Errors of the worst channel:
/// `own` against the method's own leaf sums, `total` against the area integral, `leaves` of the leaf sums against the
/// area integral. `own_front` and `total_front` tell whether a point is on the front of its lighting by that L2.
const COLUMNS: [&str; 27] = [
    "device",
    "driver",
    "scene",
    "faces",
    "extent_mm",
    "material",
    "samples",
    "frames",
    "light",
    "method",
    "parameter",
    "value",
    "device_ms",
    "wall_ms",
    "wall_low_ms",
    "wall_high_ms",
    "busy",
    "own_l2",
    "own_p99",
    "own_max",
    "own_front",
    "leaves_l2",
    "total_l2",
    "total_p99",
    "total_max",
    "total_front",
    "links_per_face",
];

/// The columns against a walk, if there is one: L2 of means over patches, and the walk's own noise.
const TRUTH: [&str; 4] = ["truth_l2_r", "truth_l2_g", "truth_l2_b", "truth_noise"];

/// All points as CSV; a point without measurements has empty cells and the reason in the last column, `left_out`.
pub fn csv(sweep: &Sweep, origin: &Origin) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let lost = |error: &dyn std::fmt::Display| Error::Check(format!("the table could not be written: {error}"));
    let truth: &[&str] = if sweep.truth.is_some() { &TRUTH } else { &[] };
    writer.write_record(COLUMNS.iter().chain(truth).copied().chain(["left_out"])).map_err(|e| lost(&e))?;
    let fronts = [Against::Own, Against::Total].map(|against| mark(sweep, against));
    for (k, point) in sweep.points.iter().enumerate() {
        let (run, why) = match &point.run {
            Ok(run) => (Some(run), ""),
            Err(why) => (None, why.as_str()),
        };
        let named = !point.method.parameter.is_empty();
        let number = |x: Option<f64>| x.filter(|x| !x.is_nan()).map_or_else(String::new, |x| format!("{x:.6e}"));
        let of = |norms: Option<Norms>, front: bool| {
            let [l2, p99, max] = [|n: Norms| n.l2, |n: Norms| n.p99, |n: Norms| n.max].map(|f| number(norms.map(f)));
            [l2, p99, max, if norms.is_some() { u8::from(front).to_string() } else { String::new() }]
        };
        let mut cells = vec![
            origin.device.clone(),
            origin.driver.clone(),
            origin.scene.clone(),
            origin.faces.to_string(),
            origin.extent_mm.to_string(),
            origin.material.clone(),
            sweep.samples.to_string(),
            origin.repeat.to_string(),
            point.lighting.name().to_string(),
            point.method.name.to_string(),
            point.method.parameter.to_string(),
            if named { point.value.to_string() } else { String::new() },
            number(run.and_then(|run| run.device_ms)),
            number(run.map(|run| run.wall_ms)),
            number(run.map(|run| run.range_ms[0])),
            number(run.map(|run| run.range_ms[1])),
            number(run.map(|run| run.busy)),
        ];
        cells.extend(of(run.map(|run| run.own), fronts[0][k]));
        cells.push(number(run.map(|_| if point.method.leaves == Leaves::Exact { 0.0 } else { sweep.midpoint.l2 })));
        cells.extend(of(run.map(|run| run.total), fronts[1][k]));
        cells.push(number(run.and_then(|run| run.links_per_face)));
        if sweep.truth.is_some() {
            let found = run.and_then(|run| run.truth);
            cells.extend((0..3).map(|c| number(found.map(|found| found.l2[c]))));
            cells.push(number(found.map(|found| found.noise)));
        }
        cells.push(why.to_string());
        writer.write_record(&cells).map_err(|e| lost(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| lost(&e))?;
    String::from_utf8(bytes).map_err(|e| lost(&e))
}

#[cfg(test)]
mod tests {
    use super::super::{Lighting, METHODS, Point, Run};
    use super::*;
    use crate::measure::truth::TruthError;

    #[test]
    fn one_row_a_point_and_as_many_cells_as_columns() {
        let norms = Norms { l2: 1e-3, p99: 2e-3, max: 3e-3 };
        let run = Run {
            device_ms: None,
            wall_ms: 2.5,
            range_ms: [2.0, 3.0],
            busy: 1.25,
            own: norms,
            total: norms,
            truth: Some(TruthError { l2: [0.1, 0.2, 0.3], noise: 0.01 }),
            links_per_face: Some(12.5),
        };
        let point = |run| Point { method: &METHODS[0], value: 0.1, lighting: Lighting::Moves, run };
        let points = vec![point(Ok(run)), point(Err("too slow, by far".into()))];
        let sweep = Sweep { points, samples: 7, midpoint: norms, truth: Some("a walk".into()) };
        let origin = Origin {
            device: "a device".into(),
            driver: "1, 2".into(),
            scene: "ball".into(),
            faces: 80,
            extent_mm: 10.0,
            material: "Marble".into(),
            repeat: 5,
        };
        let text = csv(&sweep, &origin).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        let rows: Vec<_> = reader.records().map(|row| row.unwrap()).collect();
        assert_eq!((rows.len(), header.len()), (2, COLUMNS.len() + TRUTH.len() + 1));
        let cell = |row: usize, name: &str| rows[row].get(header.iter().position(|h| h == name).unwrap()).unwrap();
        assert_eq!((cell(0, "driver"), cell(0, "device_ms"), cell(0, "own_front")), ("1, 2", "", "1"));
        assert_eq!(cell(0, "wall_high_ms").parse::<f64>(), Ok(3.0));
        assert_eq!((cell(0, "leaves_l2").parse::<f64>(), cell(0, "links_per_face").parse()), (Ok(0.0), Ok(12.5)));
        assert_eq!((cell(0, "truth_l2_b").parse(), cell(0, "truth_noise").parse()), (Ok(0.3), Ok(0.01)));
        assert_eq!((cell(1, "wall_ms"), cell(1, "own_front"), cell(1, "left_out")), ("", "", "too slow, by far"));
    }
}
