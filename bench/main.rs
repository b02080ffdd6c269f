//! `cargo bench -- NAME...`: measurements on the default device, as text. Names are those of the sections of
//! `milkglass report`, of which this prints what a terminal can show, and of the measurements that are only here:
//!
//! - `stages`: each stage on the device and on the CPU, once both agree. This is what runs without a name.
//! - `hierarchies`: the four trees on one deforming object.
//! - `form-factor`: cost and error of one form factor, on every device.
//! - `walk`: photons a second, beside a plain native program of the same walk.
//! - `truth-by-time`: error against a random walk by run time, in three materials; writes a table and a chart.
//! - `local`, `modes`, `tables`: parts of the sections `kubo`, `modes` and `mertens` for scenes of your own.
//!
//! Other words are scenes or meshes to measure in place of the built-in ones. `--set KEY=VALUE` changes them, `--quick`
//! measures less, `--cpu` measures the CPU. The functions that take other options name them.

mod form_factor;
mod hierarchies;
mod scenes;
mod truth;

use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::measure::report::{Bench, Page, SECTIONS};

/// The arguments.
#[derive(Default)]
pub struct Asked {
    names: Vec<String>,
    /// Scenes and meshes.
    files: Vec<String>,
    sets: Vec<String>,
    options: Vec<(String, String)>,
}

impl Asked {
    /// The number after this option, or another one.
    fn number(&self, option: &str, otherwise: f64) -> Result<f64> {
        let Some((_, text)) = self.options.iter().rfind(|(name, _)| name == option) else { return Ok(otherwise) };
        let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
        Ok(number.ok_or_else(|| Input::new("not a number").key(option).found(text).expected("0 or more"))?)
    }

    /// The words after this option, or others.
    fn words<'a>(&'a self, option: &str, otherwise: &'a str) -> &'a str {
        self.options.iter().rfind(|(name, _)| name == option).map_or(otherwise, |(_, words)| words)
    }

    /// The scenes that are named, or else these.
    fn scenes(&self, otherwise: &[&str]) -> Vec<String> {
        if self.files.is_empty() { otherwise.iter().map(ToString::to_string).collect() } else { self.files.clone() }
    }
}

/// Measures and writes what it finds.
type Measure = fn(&Asked, &Bench<'_>, &mut Page) -> Result<()>;

/// The measurements that are only here, by name.
const BENCHES: [(&str, Measure); 8] = [
    ("stages", scenes::stages),
    ("hierarchies", hierarchies::hierarchies),
    ("form-factor", form_factor::form_factor),
    ("walk", scenes::walk),
    ("truth-by-time", truth::truth),
    ("local", scenes::local),
    ("modes", scenes::modes),
    ("tables", scenes::tables),
];

fn run() -> Result<()> {
    let (mut asked, mut quick, mut cpu) = (Asked::default(), false, false);
    let mut words = std::env::args().skip(1);
    let known =
        |name: &str| BENCHES.iter().any(|bench| bench.0 == name) || SECTIONS.iter().any(|part| part.name == name);
    while let Some(word) = words.next() {
        match word.as_str() {
            // Passed by cargo itself.
            "--bench" => {}
            "--quick" => quick = true,
            "--cpu" => cpu = true,
            "--set" => asked.sets.extend(words.next()),
            option if option.starts_with("--") => asked.options.extend(words.next().map(|value| (word, value))),
            name if known(name) => asked.names.push(word),
            _ => asked.files.push(word),
        }
    }
    if asked.names.is_empty() {
        asked.names.push(BENCHES[0].0.into());
    }
    let device = if cpu { None } else { Device::best()? };
    println!("{}", device.as_ref().map_or("the CPU".into(), |d| format!("{}, {}", d.name(), d.driver())));
    let bench = Bench { device: device.as_ref(), quick, ..Bench::default() };
    for name in &asked.names {
        let mut page = Page::default();
        match (BENCHES.iter().find(|bench| bench.0 == name), SECTIONS.iter().find(|part| part.name == name)) {
            (Some((_, measure)), _) => measure(&asked, &bench, &mut page)?,
            (_, Some(section)) => (section.write)(&bench, &mut page)?,
            _ => {}
        }
        println!("\n{name}\n{}", page.text);
        page.findings
            .iter()
            .for_each(|finding| println!("{}: {}: {}", finding.tone.mark().1, finding.aim, finding.found));
        if !page.faults.is_empty() {
            return Err(Error::Check(page.faults.join("\n")));
        }
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
