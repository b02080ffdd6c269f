//! Files of what compilers report.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::record::{Compiled, Pipeline, Sheets};
use milkglass::error::{Error, Input, Result};

/// The columns of CSV.
const HEADER: [&str; 5] = ["compiler", "kernel", "constants", "statistic", "value"];

/// Everything that the compilers reported except hashes, as CSV.
pub(super) fn csv(sheets: &Sheets) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut add = |row: [&str; 5]| writer.write_record(row).map_err(|error| Error::device("writing CSV", error));
    add(HEADER)?;
    for (family, sheet) in sheets {
        for pipeline in &sheet.pipelines {
            for (name, value) in reported(pipeline) {
                add([family, &pipeline.kernel, &pipeline.constants, name, &value.to_string()])?;
            }
        }
    }
    writer.into_inner().map_err(|error| Error::device("writing CSV", error))
}

/// The same as JSON, with times, and with the built-in kernels that were replaced: an object of each compiler.
pub(super) fn json(sheets: &Sheets) -> Result<Vec<u8>> {
    let pipelines = |pipelines: &[Pipeline]| -> Vec<Value> {
        let object = |pipeline: &Pipeline| {
            json!({
                "kernel": pipeline.kernel,
                "constants": pipeline.constants,
                "milliseconds": pipeline.milliseconds,
                "statistics": reported(pipeline).cloned().collect::<BTreeMap<String, f64>>(),
            })
        };
        pipelines.iter().map(object).collect()
    };
    let compiler = |(family, sheet): (&String, &Compiled)| {
        let (all, built_in) = (pipelines(&sheet.pipelines), pipelines(&sheet.built_in));
        (family.clone(), json!({ "device": sheet.device, "pipelines": all, "built_in": built_in }))
    };
    let compilers: BTreeMap<String, Value> = sheets.iter().map(compiler).collect();
    let all = json!({ "schema": "milkglass-compile-1", "compilers": compilers });
    serde_json::to_vec_pretty(&all).map_err(|error| Error::device("writing JSON", error))
}

/// What a compiler reported of a pipeline, except hashes.
fn reported(pipeline: &Pipeline) -> impl Iterator<Item = &(String, f64)> {
    pipeline.statistics.iter().filter(|(name, _)| !name.to_lowercase().contains("hash"))
}

/// Reads such CSV.
pub(super) fn read(path: &Path) -> Result<Sheets> {
    let fault = |what: &str| Input::new(what).file(path).key("--baseline");
    let mut reader = csv::Reader::from_path(path).map_err(|error| fault("the file could not be read").found(error))?;
    let other =
        |found: &dyn std::fmt::Display| fault("not what compile writes").found(found).expected(HEADER.join(","));
    let header = reader.headers().map_err(|error| other(&error))?;
    if header != HEADER.as_slice() {
        return Err(other(&header.iter().collect::<Vec<_>>().join(",")).into());
    }
    let mut sheets = Sheets::new();
    for record in reader.deserialize::<(String, String, String, String, f64)>() {
        let (family, kernel, constants, name, value) = record.map_err(|error| other(&error))?;
        if !value.is_finite() {
            return Err(other(&format!("{kernel}: {name} {value}")).into());
        }
        let pipelines = &mut sheets.entry(family).or_default().pipelines;
        match pipelines.iter_mut().find(|known| known.kernel == kernel && known.constants == constants) {
            Some(known) => known.statistics.push((name, value)),
            None => pipelines.push(Pipeline { kernel, constants, milliseconds: 0.0, statistics: vec![(name, value)] }),
        }
    }
    Ok(sheets)
}
