//! A sweep as CSV: one row per point, each complete in itself.

use super::{Against, Leaves, Point, Run, Sweep, mark};
use crate::error::Result;
use crate::gpu::Device;
use crate::measure::table::{Column, Table};
use crate::measure::truth::TruthError;
use crate::scene::{Material, Scene};

/// The origin of a sweep.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The device's name.
    pub device: String,
    /// Its driver and the driver's version.
    pub driver: String,
    /// The scene's name.
    pub scene: String,
    /// The number of faces of all objects.
    pub faces: usize,
    /// The scene's largest extent, millimetres, to six digits.
    pub extent_mm: f64,
    /// Names and coefficients of all materials, in words.
    pub material: String,
    /// Timed frames per point.
    pub repeat: usize,
}

impl Origin {
    /// The origin of a sweep over a scene on a device; `None` for the CPU.
    #[must_use]
    pub fn new(scene: &Scene, device: Option<&Device>, repeat: usize) -> Self {
        Self {
            device: device.map_or("cpu", Device::name).to_string(),
            driver: device.map_or("the f64 reference", Device::driver).to_string(),
            scene: scene.name.clone(),
            faces: scene.objects.iter().map(|object| object.mesh.triangles.len()).sum(),
            extent_mm: extent_mm(scene),
            material: materials(scene),
            repeat,
        }
    }
}

/// The largest extent in millimetres, rounded to six digits.
fn extent_mm(scene: &Scene) -> f64 {
    let (low, high) = scene.bounds();
    let extent = (high - low).max_element() * scene.unit_mm;
    format!("{extent:.5e}").parse().unwrap_or(extent)
}

/// Names and coefficients per millimetre of all materials.
fn materials(scene: &Scene) -> String {
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

/// All points as CSV; what is not known is empty. Times are medians in milliseconds; `wall_low_ms` and `wall_high_ms`
/// are the fastest and slowest frame, `busy` the time of a fixed job over its fastest time. Errors of the worst
/// channel: `own` against the method's own leaf sums, `total` against the area integral, `leaves` of the leaf sums
/// against the area integral. `own_front` and `total_front` tell whether a point is on the front of its lighting by
/// that L2. If there is a walk, `truth` is the L2 of means over patches against it, and `truth_noise` its own noise. A
/// point without measurements has the reason in the last column, `left_out`.
pub fn csv(sweep: &Sweep, origin: &Origin) -> Result<String> {
    let fronts = [Against::Own, Against::Total].map(|against| mark(sweep, against));
    let points: Vec<(usize, &Point)> = sweep.points.iter().enumerate().collect();
    let known = |x: f64| if x.is_nan() { String::new() } else { format!("{x:.6e}") };
    let number = |point: &Point, value: &dyn Fn(&Run) -> Option<f64>| {
        point.run.as_ref().ok().and_then(value).map_or_else(String::new, known)
    };
    let on_front = |(k, point): &(usize, &Point), front: usize| {
        point.run.as_ref().map_or_else(|_| String::new(), |_| u8::from(fronts[front][*k]).to_string())
    };
    let leaves = |point: &Point| if point.method.leaves == Leaves::Exact { 0.0 } else { sweep.midpoint.l2 };
    let truth = |point: &Point, value: &dyn Fn(TruthError) -> f64| number(point, &|run| run.truth.map(value));
    let before: [Column<'_, (usize, &Point)>; 27] = [
        ("device", "", &|_| origin.device.clone()),
        ("driver", "", &|_| origin.driver.clone()),
        ("scene", "", &|_| origin.scene.clone()),
        ("faces", "", &|_| origin.faces.to_string()),
        ("extent_mm", "", &|_| origin.extent_mm.to_string()),
        ("material", "", &|_| origin.material.clone()),
        ("samples", "", &|_| sweep.samples.to_string()),
        ("frames", "", &|_| origin.repeat.to_string()),
        ("light", "", &|(_, p)| p.lighting.name().into()),
        ("method", "", &|(_, p)| p.method.name.into()),
        ("parameter", "", &|(_, p)| p.method.parameter.into()),
        ("value", "", &|(_, p)| if p.method.parameter.is_empty() { String::new() } else { p.value.to_string() }),
        ("device_ms", "", &|(_, p)| number(p, &|run| run.device_ms)),
        ("wall_ms", "", &|(_, p)| number(p, &|run| Some(run.wall_ms))),
        ("wall_low_ms", "", &|(_, p)| number(p, &|run| Some(run.range_ms[0]))),
        ("wall_high_ms", "", &|(_, p)| number(p, &|run| Some(run.range_ms[1]))),
        ("busy", "", &|(_, p)| number(p, &|run| Some(run.busy))),
        ("own_l2", "", &|(_, p)| number(p, &|run| Some(run.own.l2))),
        ("own_p99", "", &|(_, p)| number(p, &|run| Some(run.own.p99))),
        ("own_max", "", &|(_, p)| number(p, &|run| Some(run.own.max))),
        ("own_front", "", &|row| on_front(row, 0)),
        ("leaves_l2", "", &|(_, p)| number(p, &|_| Some(leaves(p)))),
        ("total_l2", "", &|(_, p)| number(p, &|run| Some(run.total.l2))),
        ("total_p99", "", &|(_, p)| number(p, &|run| Some(run.total.p99))),
        ("total_max", "", &|(_, p)| number(p, &|run| Some(run.total.max))),
        ("total_front", "", &|row| on_front(row, 1)),
        ("links_per_face", "", &|(_, p)| number(p, &|run| run.links_per_face)),
    ];
    let against_walk: [Column<'_, (usize, &Point)>; 4] = [
        ("truth_l2_r", "", &|(_, p)| truth(p, &|found| found.l2[0])),
        ("truth_l2_g", "", &|(_, p)| truth(p, &|found| found.l2[1])),
        ("truth_l2_b", "", &|(_, p)| truth(p, &|found| found.l2[2])),
        ("truth_noise", "", &|(_, p)| truth(p, &|found| found.noise)),
    ];
    let walked = if sweep.truth.is_some() { &against_walk[..] } else { &[] };
    let why: Column<'_, (usize, &Point)> = ("left_out", "", &|(_, p)| p.run.clone().err().unwrap_or_default());
    Table::of(&points, &[&before[..], walked, &[why]].concat()).csv()
}

#[cfg(test)]
mod tests {
    use super::super::{Lighting, METHODS};
    use super::*;
    use crate::measure::norms::Norms;

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
        assert_eq!((rows.len(), header.len()), (2, 27 + 4 + 1));
        let cell = |row: usize, name: &str| rows[row].get(header.iter().position(|h| h == name).unwrap()).unwrap();
        assert_eq!((cell(0, "driver"), cell(0, "device_ms"), cell(0, "own_front")), ("1, 2", "", "1"));
        assert_eq!(cell(0, "wall_high_ms").parse::<f64>(), Ok(3.0));
        assert_eq!((cell(0, "leaves_l2").parse::<f64>(), cell(0, "links_per_face").parse()), (Ok(0.0), Ok(12.5)));
        assert_eq!((cell(0, "truth_l2_b").parse(), cell(0, "truth_noise").parse()), (Ok(0.3), Ok(0.01)));
        assert_eq!((cell(1, "wall_ms"), cell(1, "own_front"), cell(1, "left_out")), ("", "", "too slow, by far"));
    }
}
