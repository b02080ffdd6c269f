//! Radiosity as a random walk finds it, over patches: the reference of errors that includes those of the model.

use std::path::Path;
use std::time::Duration;

use crate::error::{Input, Result};
use crate::gpu::Device;
use crate::measure::norms::Norms;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::patches::patches;
use crate::session::run::Session;
use crate::session::walk::WalkControl;

/// A walk's result on a patch.
#[derive(Clone, Debug)]
struct Patch {
    /// Its triangles, numbered through all meshes.
    faces: Vec<usize>,
    /// Their area.
    area: f64,
    /// Mean radiosity, in the scene's units, per channel.
    mean: [f64; 3],
    /// The variance of that mean, per channel.
    variance: [f64; 3],
}

/// A walk's radiosity, in the scene's units.
#[derive(Clone, Debug)]
pub struct Truth {
    patches: Vec<Patch>,
    /// Area of each triangle.
    areas: Vec<f64>,
    /// Where the radiosity comes from, in words.
    pub about: String,
}

/// An error against a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthError {
    /// Relative L2 of means over patches, per channel; the walk's noise is taken off.
    pub l2: [f64; 3],
    /// The walk's own noise, likewise, of the worst channel: below it an error says nothing.
    pub noise: f64,
}

impl TruthError {
    /// The error of the worst channel; other norms are not measured.
    #[must_use]
    pub fn norms(&self) -> Norms {
        Norms { l2: self.l2.into_iter().fold(0.0, f64::max), p99: f64::NAN, max: f64::NAN }
    }
}

impl Truth {
    /// The walk of this name: `walk`, `walk:SECONDS`, or a file.
    pub fn find(name: &str, scene: &Scene, device: Option<&Device>, control: WalkControl) -> Result<Self> {
        let walk = |within| Self::walk(scene, device, WalkControl { within, ..control });
        match name.split_once(':') {
            Some(("walk", seconds)) => {
                let time = seconds.parse().ok().and_then(|x| Duration::try_from_secs_f64(x).ok());
                let fault = Input::new("not a time").key("--truth").found(seconds).expected("walk:SECONDS, above 0");
                walk(Some(time.filter(|time| !time.is_zero()).ok_or(fault)?))
            }
            _ if name == "walk" => walk(None),
            _ => Self::read(Path::new(name), scene),
        }
    }

    /// Walks through a scene, until `transport.walk_error` or `transport.walks` is reached, or within its time.
    pub fn walk(scene: &Scene, device: Option<&Device>, control: WalkControl) -> Result<Self> {
        let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(scene, device, options)?;
        session.watch_walk(control);
        if let (Some(caveat), Some(tell)) = (session.walk_caveat(), control.tell) {
            tell(&caveat);
        }
        session.frame(Change::EVERYTHING)?;
        Self::of_session(&mut session)
    }

    /// The result of the last frame of a session whose transport is a walk.
    pub fn of_session(session: &mut Session) -> Result<Self> {
        let photons: u64 = session.walk_reports().iter().map(|report| u64::from(report.photons)).sum();
        let rows: Vec<Row> = session
            .faces()?
            .into_iter()
            .map(|face| Row { area: face.area, value: face.radiosity, error: face.noise.unwrap_or_default() })
            .collect();
        Ok(Self::of(session, &rows, format!("a walk of {photons} photons a channel")))
    }

    /// Reads a walk's result for a scene: CSV with a row for each triangle, columns `area`, `B_r`, `B_g`, `B_b`, and
    /// the standard errors `se_r`, `se_g`, `se_b`, as `solve --transport walk` writes it.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self> {
        let fault = |what: &str| Input::new(what).file(path).key("--truth");
        let text = std::fs::read_to_string(path).map_err(|error| {
            fault("the file can't be read").found(error).expected("walk, walk:SECONDS, or a CSV file of a walk")
        })?;
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| fault("not CSV").found(error))?.clone();
        let mut places = [0; 7];
        for (place, name) in places.iter_mut().zip(["area", "B_r", "B_g", "B_b", "se_r", "se_g", "se_b"]) {
            let missing =
                || fault("a column is missing").found(header.iter().collect::<Vec<_>>().join(",")).expected(name);
            *place = header.iter().position(|own| own.trim() == name).ok_or_else(missing)?;
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| fault("not CSV").found(error))?;
            let line = record.position().map_or(0, csv::Position::line);
            let mut numbers = [0.0; 7];
            for (number, &place) in numbers.iter_mut().zip(&places) {
                let cell = record.get(place).unwrap_or_default().trim();
                let sound = cell.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
                *number = sound.ok_or_else(|| {
                    fault("not a value of a walk").line(line as usize).found(cell).expected("a number of at least 0")
                })?;
            }
            let [area, r, g, b, se_r, se_g, se_b] = numbers;
            rows.push(Row { area, value: [r, g, b], error: [se_r, se_g, se_b] });
        }
        let faces: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
        if rows.len() != faces {
            let found = format!("{} rows", rows.len());
            return Err(fault("the walk is of another mesh")
                .found(found)
                .expected(format!("{faces}, one a triangle"))
                .into());
        }
        let options = Options { transport: ShadingMethod::None, goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(scene, None, options)?;
        session.frame(Change::EVERYTHING)?;
        Ok(Self::of(&session, &rows, path.display().to_string()))
    }

    /// Means over the patches of all objects that light enters.
    fn of(session: &Session, rows: &[Row], about: String) -> Self {
        let (mut all, mut first) = (Vec::new(), 0);
        for (number, object) in session.state().objects.iter().enumerate() {
            let places = session.prepared().places(number);
            // Rows are of whole triangles: of a subdivided one, its part in the middle stands for it.
            let shown: Vec<usize> = match session.parts().get(number) {
                Some(parts) => parts.middle.iter().map(|&part| places[part as usize]).collect(),
                None => places,
            };
            let mut of_place = vec![None; object.count.faces];
            shown
                .iter()
                .enumerate()
                .for_each(|(face, place)| of_place[place - object.first.faces] = Some(first + face));
            first += shown.len();
            if object.opaque {
                continue;
            }
            for part in patches(session.state(), number) {
                let faces: Vec<usize> = of_place[part].iter().flatten().copied().collect();
                let area: f64 = faces.iter().map(|&face| rows[face].area).sum();
                let mean = |value: &dyn Fn(&Row) -> f64, by: f64| {
                    if by > 0.0 { faces.iter().map(|&face| value(&rows[face])).sum::<f64>() / by } else { 0.0 }
                };
                all.push(Patch {
                    area,
                    mean: [0, 1, 2].map(|c| mean(&|row| row.area * row.value[c], area)),
                    variance: [0, 1, 2].map(|c| mean(&|row| (row.area * row.error[c]).powi(2), area * area)),
                    faces,
                });
            }
        }
        Self { patches: all, areas: rows.iter().map(|row| row.area).collect(), about }
    }

    /// The error of the radiosity of all triangles, numbered through all meshes.
    #[must_use]
    pub fn error(&self, radiosity: &[[f64; 3]]) -> TruthError {
        let mut noise = 0.0;
        let l2 = [0, 1, 2].map(|c| {
            let (mut off, mut variance, mut power) = (0.0, 0.0, 0.0);
            for patch in self.patches.iter().filter(|patch| patch.area > 0.0) {
                let sum: f64 = patch.faces.iter().map(|&face| self.areas[face] * radiosity[face][c]).sum();
                off += patch.area * (sum / patch.area - patch.mean[c]).powi(2);
                variance += patch.area * patch.variance[c];
                power += patch.area * (patch.mean[c].powi(2) - patch.variance[c]);
            }
            let share = |x: f64| if x <= 0.0 { 0.0 } else { (x / power.max(0.0)).sqrt() };
            noise = f64::max(noise, share(variance));
            share(off - variance)
        });
        TruthError { l2, noise }
    }
}

/// A walk's result at a triangle: area, radiosity and standard error.
struct Row {
    area: f64,
    value: [f64; 3],
    error: [f64; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(faces: Vec<usize>, mean: f64, variance: f64) -> Patch {
        Patch { area: faces.len() as f64, faces, mean: [mean, 2.0 * mean, 0.0], variance: [variance, 0.0, 0.0] }
    }

    #[test]
    fn errors_are_over_patches_without_the_noise() {
        let patches = vec![patch(vec![0, 2], 1.0, 0.01), patch(vec![1], 2.0, 0.03)];
        let truth = Truth { patches, areas: vec![1.0; 3], about: String::new() };
        // Within a patch only the mean counts: 1.1 for 1, 2.2 for 2.
        let values = [0.2, 2.2, 2.0].map(|x| [x, 2.0 * x, 0.0]);
        let found = truth.error(&values);
        let (off, variance, power): (f64, f64, f64) = (2.0 * 0.01 + 0.04, 2.0 * 0.01 + 0.03, 2.0 * 0.99 + 3.97);
        assert!((found.l2[0] - ((off - variance) / power).sqrt()).abs() < 1e-12, "{found:?}");
        assert!((found.l2[1] - 0.1).abs() < 1e-12 && found.l2[2] == 0.0);
        assert!((found.noise - (variance / power).sqrt()).abs() < 1e-12);
        // Less than the noise is nothing.
        assert_eq!(truth.error(&[[1.0, 2.0, 0.0], [2.0, 4.0, 0.0], [1.0, 2.0, 0.0]]).l2, [0.0; 3]);
    }
}
