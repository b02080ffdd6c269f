//! Where results go as they come: the table on standard output, and lines of JSON.

use std::fs::File;
use std::io::Write;

use super::arguments::Arguments;
use super::choose::Choice;
use super::expect::Known;
use super::junit;
use super::sheet::Sheet;
use crate::cli::run_args::quoted;
use crate::cli::{now, print, write};
use milkglass::error::{Input, Result};
use milkglass::measure::conform::BINS;
use milkglass::measure::results::{DeviceFacts, Line, Outcome, Results, Run, SCHEMA, system};

/// Everything that each result goes to.
pub(super) struct Sink {
    /// The results so far.
    pub(super) all: Results,
    /// What is expected to fail.
    pub(super) known: Vec<Known>,
    /// The names of replaced kernels.
    pub(super) replaced: Vec<String>,
    lines: Option<File>,
    sheet: Option<Sheet>,
    child: bool,
}

impl Sink {
    /// Opens the file of lines, and writes the line that describes the run.
    pub(super) fn open(
        arguments: &Arguments,
        choices: &[Choice],
        layer: Option<String>,
        devices: Vec<DeviceFacts>,
        kernels: &[(String, Vec<u32>)],
        known: Vec<Known>,
    ) -> Result<Self> {
        let words: Vec<String> = std::env::args().skip(1).map(|word| quoted(&word)).collect();
        let run = Run {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            commit: option_env!("MILKGLASS_COMMIT").map(str::to_string),
            system: system(),
            layer,
            date: now(),
            command: format!("milkglass {}", words.join(" ")),
            most_ulp_of_bins: BINS.to_vec(),
            devices,
        };
        let lines = match &arguments.jsonl {
            Some(path) => Some(
                File::create(path).map_err(|error| Input::new(format!("could not be written: {error}")).file(path))?,
            ),
            None => None,
        };
        let mut sink = Self {
            sheet: (!arguments.child).then(|| Sheet::new(&run.devices, choices)),
            all: Results { run: run.clone(), results: Vec::new() },
            known,
            replaced: kernels.iter().map(|(name, _)| name.clone()).collect(),
            lines,
            child: arguments.child,
        };
        sink.line(&Line::Run(run))?;
        Ok(sink)
    }

    /// Writes a line of JSON to the file, and in a child to standard output.
    fn line(&mut self, line: &Line) -> Result<()> {
        if self.lines.is_none() && !self.child {
            return Ok(());
        }
        let fault = |error: &dyn std::fmt::Display| Input::new(format!("a result could not be written: {error}"));
        let text = serde_json::to_string(line).map_err(|error| fault(&error))? + "\n";
        if self.child {
            print(&text)?;
        }
        if let Some(file) = &mut self.lines {
            file.write_all(text.as_bytes()).and_then(|()| file.flush()).map_err(|error| fault(&error))?;
        }
        Ok(())
    }

    /// A comparison begins.
    pub(super) fn begins(&mut self, fixture: &str, stage: &str) -> Result<()> {
        self.line(&Line::Begins(fixture.into(), stage.into()))
    }

    /// A comparison has ended.
    pub(super) fn add(&mut self, mut outcome: Outcome) -> Result<()> {
        if !outcome.verdict.passes() {
            outcome.known = self.known.iter_mut().find(|known| known.fits(&outcome)).map(Known::met);
        }
        self.line(&Line::Result(Box::new(outcome.clone())))?;
        if let Some(sheet) = &mut self.sheet {
            print(&sheet.row(&outcome))?;
        }
        self.all.results.push(outcome);
        Ok(())
    }

    /// Writes the files of all results.
    pub(super) fn finish(&self, arguments: &Arguments) -> Result<()> {
        if let Some(path) = &arguments.json {
            let text = serde_json::to_string_pretty(&self.all)
                .map_err(|error| Input::new(format!("could not be written: {error}")).file(path))?;
            write(path, text + "\n")?;
        }
        if let Some(path) = &arguments.junit {
            let text = junit::report(&self.all, &self.known)
                .map_err(|error| Input::new(format!("could not be written: {error}")).file(path))?;
            write(path, text)?;
        }
        Ok(())
    }
}
