//! `milkglass eval`: evaluates one function per row of a table, to check the kernels from outside.

mod layered;

use std::path::Path;

use csv::StringRecord;
use glam::DVec3;

use crate::dipole::form_factor::Distance;
use crate::dipole::form_factor::exact::edge_form_exact;
use crate::dipole::profile::Dipole;
use crate::error::{Error, Input, Result};
use crate::gpu::Device;
use crate::layout::{BufferId, Query};
use crate::lighting::fresnel;
use crate::scene::Fresnel;
use crate::shading::cdrf_values;
use crate::shading::reflectance::cdrf;
use crate::state::{DeviceState, Scope, State, Step};
use crate::transport::evaluate;

/// The function to evaluate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Kind {
    /// Form factor of a triangle and a point.
    FormFactor,
    /// The diffuse reflectance profile.
    Profile,
    /// Single scattering of a flat slab of layers.
    Layered,
    /// The curvature-dependent reflectance function.
    Cdrf,
}

impl Kind {
    /// The columns that the function requires.
    fn columns(self) -> Vec<&'static str> {
        let medium = ["sigma_s_prime", "sigma_a", "eta"];
        match self {
            Self::FormFactor => [&CORNERS[..], &medium].concat(),
            Self::Profile => [&["r"][..], &medium].concat(),
            Self::Layered => layered::COLUMNS.to_vec(),
            Self::Cdrf => vec!["cos_theta", "sigma"],
        }
    }
}

/// A row in dimensionless form: lengths in units of `unit`.
struct Row {
    triangle: [DVec3; 3],
    dipole: Dipole,
    unit: f64,
}

const CORNERS: [&str; 12] = ["v0x", "v0y", "v0z", "v1x", "v1y", "v1z", "v2x", "v2y", "v2z", "xox", "xoy", "xoz"];

/// Evaluates a CSV table and returns it with the values appended; `file` is its name in messages. `open` returns the
/// device to evaluate on, or `None` for the CPU. An error names the line and the column.
pub fn answers(
    kind: Kind,
    formula: Fresnel,
    file: &Path,
    text: &[u8],
    open: impl FnOnce() -> Result<Option<Device>>,
) -> Result<Vec<u8>> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text);
    let header = reader.headers().map_err(|e| bad_row(file, &e))?.clone();
    if let Some(key) = kind.columns().into_iter().find(|key| !header.iter().any(|name| name == *key)) {
        let fault = Input::new("this column is missing").file(file).line(1).key(key);
        return Err(fault.expected("a column of this name").into());
    }
    let records = reader.into_records().collect::<std::result::Result<Vec<_>, _>>().map_err(|e| bad_row(file, &e))?;
    let cells = records.iter().map(|record| Cells { file, header: &header, record });
    let values = if kind == Kind::Layered {
        let rows = cells.map(|cells| layered::row(&cells)).collect::<std::result::Result<Vec<_>, Input>>()?;
        layered::evaluate(&rows, open()?.as_ref())?
    } else {
        let rows = cells.map(|cells| row(kind, formula, &cells)).collect::<std::result::Result<Vec<_>, Input>>()?;
        evaluate(kind, open()?, &rows)?
    };

    // Write the input's columns, then the values.
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names: &[&str] = if kind == Kind::FormFactor { &["value", "value_radial"] } else { &["value"] };
    let write = |e: csv::Error| Error::from(Input::new(e.to_string()).file(file));
    writer.write_record(header.iter().chain(names.iter().copied())).map_err(write)?;
    for (record, value) in records.iter().zip(values) {
        if let Some(value) = value[..names.len()].iter().find(|x| !x.is_finite()) {
            let cells = Cells { file, header: &header, record };
            let fault = cells.fault("value", "these numbers are beyond what can be evaluated").found(value);
            return Err(fault.expected("a row whose value is a finite number").into());
        }
        let cells: Vec<String> = value.iter().take(names.len()).map(|x| format!("{x:e}")).collect();
        writer.write_record(record.iter().chain(cells.iter().map(String::as_str))).map_err(write)?;
    }
    writer.into_inner().map_err(|e| Input::new(e.to_string()).file(file).into())
}

fn bad_row(file: &Path, error: &csv::Error) -> Input {
    let input = Input::new(error.to_string()).file(file);
    match error.position() {
        Some(position) => input.line(position.line() as usize),
        None => input,
    }
}

/// The cells of a row, by column name.
struct Cells<'a> {
    file: &'a Path,
    header: &'a StringRecord,
    record: &'a StringRecord,
}

impl Cells<'_> {
    fn fault(&self, key: &str, what: &str) -> Input {
        let line = self.record.position().map_or(0, |position| position.line() as usize);
        Input::new(what).file(self.file).line(line).key(key)
    }

    fn text(&self, key: &str) -> &str {
        let column = self.header.iter().position(|name| name == key);
        column.and_then(|column| self.record.get(column)).unwrap_or("")
    }

    fn number(&self, key: &str) -> std::result::Result<f64, Input> {
        let cell = self.text(key);
        let value = cell.parse::<f64>().ok().filter(|x| x.is_finite());
        value.ok_or_else(|| self.fault(key, "not a finite number").found(format!("{cell:?}")).expected("a number"))
    }

    fn at_least(&self, key: &str, least: f64) -> std::result::Result<f64, Input> {
        let value = self.number(key)?;
        if value >= least {
            return Ok(value);
        }
        Err(self.fault(key, "out of range").found(value).expected(format!("at least {least}")))
    }
}

/// Parses one record.
fn row(kind: Kind, formula: Fresnel, cells: &Cells<'_>) -> std::result::Result<Row, Input> {
    let fault = |key: &str, what: &str| cells.fault(key, what);
    let at_least = |key: &str, least: f64| cells.at_least(key, least);

    if kind == Kind::Cdrf {
        let cosine = cells.number("cos_theta")?;
        if cosine.abs() > 1.0 {
            return Err(fault("cos_theta", "out of range").found(cosine).expected("-1 to 1"));
        }
        // No medium: `x` and `y` of the first corner hold cosine and sigma.
        let triangle = [DVec3::new(cosine, at_least("sigma", 0.0)?, 0.0), DVec3::ZERO, DVec3::ZERO];
        return Ok(Row { triangle, dipole: Dipole::new(1.0, 0.0, 1.0), unit: 1.0 });
    }

    // The medium; its mean free path is the row's unit of length.
    let (scattering, absorption) = (at_least("sigma_s_prime", 0.0)?, at_least("sigma_a", 0.0)?);
    let eta = at_least("eta", 0.5)?;
    let unit = 1.0 / (scattering + absorption);
    if !(unit.is_finite() && unit > 0.0) {
        let what =
            if unit > 0.0 { "the medium neither scatters nor absorbs" } else { "coefficients beyond all numbers" };
        let found = format!("{scattering:e} and {absorption:e}");
        return Err(fault("sigma_s_prime", what).found(found).expected("a mean free path above 0 that is a number"));
    }
    let inner = match formula {
        Fresnel::Paper => fresnel::diffuse_internal_polynomial(eta),
        Fresnel::Exact => fresnel::diffuse_internal_exact(eta),
    };
    if inner >= 1.0 {
        let what = "the polynomial F_dr reaches 1 here and means nothing";
        return Err(fault("eta", what).found(eta).expected("an eta below 3.8, or --fresnel exact"));
    }
    let dipole = Dipole::new(scattering * unit, absorption * unit, fresnel::boundary(inner));
    let mut triangle = [DVec3::ZERO; 3];
    if kind == Kind::Profile {
        triangle[0].x = at_least("r", 0.0)? / unit;
    } else {
        let mut v = [0.0; 12];
        for (value, key) in v.iter_mut().zip(CORNERS) {
            *value = cells.number(key)?;
        }
        let point = |k: usize| DVec3::new(v[k], v[k + 1], v[k + 2]);
        triangle = [0, 3, 6].map(|k| (point(k) - point(9)) / unit);
        let area = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).length_squared();
        if area == 0.0 {
            return Err(fault("v0x", "the triangle has no area, or one too small to tell"));
        }
        if !area.is_finite() {
            let expected = "at most 1e70 mean free paths";
            return Err(fault("v0x", "the triangle is too large or too far away").expected(expected));
        }
    }
    Ok(Row { triangle, dipole, unit })
}

/// Evaluates the rows: on a device by its kernels in `f32`, on the CPU in `f64`.
fn evaluate(kind: Kind, device: Option<Device>, rows: &[Row]) -> Result<Vec<[f64; 2]>> {
    let (profile, local) = (kind == Kind::Profile, kind == Kind::Cdrf);
    let Some(device) = device else {
        let value = |row: &Row| {
            if local {
                return [cdrf(row.triangle[0].x, row.triangle[0].y), 0.0];
            }
            if profile {
                return [row.dipole.radial(row.triangle[0].length_squared()) / (row.unit * row.unit), 0.0];
            }
            let form = |distance| edge_form_exact(&row.triangle, [0, 1, 2], DVec3::ZERO, &row.dipole, distance);
            [form(Distance::Table1 { clamp: false }), form(Distance::Radial)]
        };
        return Ok(rows.iter().map(value).collect());
    };
    let mut state = State::default();
    let narrow = |v: DVec3| v.to_array().map(|x| x as f32);
    state.data.queries = rows
        .iter()
        .map(|row| Query {
            a: narrow(row.triangle[0]),
            b: narrow(row.triangle[1]),
            c: narrow(row.triangle[2]),
            strength: row.dipole.strength as f32,
            sigma: row.dipole.sigma as f32,
            z_real: row.dipole.z_real as f32,
            z_virtual: row.dipole.z_virtual as f32,
        })
        .collect();
    state.data.answers = vec![[0.0; 3]; rows.len()];
    let mut device_state = DeviceState::new(&device, false)?;
    let stage = if local { &cdrf_values::STAGE } else { &evaluate::STAGE };
    let steps = [Step { stage, at: Scope::default() }];
    device_state.upload(&state, &[BufferId::queries])?;
    device_state.run(&state, &steps)?;
    device_state.download(&mut state, &[BufferId::answers])?;
    let value = |(row, answer): (&Row, &[f32; 3])| {
        let [radial, displaced, reflectance] = answer.map(f64::from);
        if local {
            return [radial, 0.0];
        }
        if profile { [reflectance / (row.unit * row.unit), 0.0] } else { [displaced, radial] }
    };
    Ok(rows.iter().zip(&state.data.answers).map(value).collect())
}
