//! Fixtures on the interpreter: their stages compared with the reference, and what is wrong in their kernels.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use super::conform::{Event, Row, SEED, add_row, compared_row, hashed, poison};
use super::fixtures::Fixture;
use super::interpret::stage::{Interpreter, SUBGROUP};
use super::interpret::{Finding, Site};
use crate::error::Result;
use crate::gpu::Adapter;
use crate::layout::BufferId;
use crate::pipeline::frame::owner;

/// The interpreter's name among devices.
pub const DEVICE: &str = "interpreter";

/// Whether the wish for a device is for the interpreter.
#[must_use]
pub fn is_asked(wish: Option<&str>) -> bool {
    wish.is_some_and(|wish| wish.eq_ignore_ascii_case(DEVICE))
}

/// The interpreter as results name a device.
#[must_use]
pub fn adapter() -> Adapter {
    let mut adapter = Adapter::default();
    (adapter.name, adapter.driver) = (DEVICE.into(), format!("milkglass {}", env!("CARGO_PKG_VERSION")));
    (adapter.version, adapter.kind) = ("1.2".into(), "cpu");
    (adapter.limits.subgroup_size, adapter.limits.round_to_nearest) = (SUBGROUP, true);
    adapter
}

/// The stages of kernels that do not come from the build.
pub fn replaced_stages(interpreter: &Interpreter) -> Vec<String> {
    let stages = interpreter.replaced().filter_map(|name| Some(owner(name)?.name.to_string()));
    stages.collect::<BTreeSet<_>>().into_iter().collect()
}

/// Whether a stage is one of these; every stage is, if there are none.
fn takes_part(stage: &str, stages: &[String]) -> bool {
    stages.is_empty() || stages.iter().any(|name| name == stage)
}

/// Compares stages of a fixture with the reference, or all if none is given; tells each event when it happens.
pub fn conform_interpreted(
    interpreter: &Interpreter,
    fixture: &Fixture,
    stages: &[String],
    told: &mut dyn FnMut(Event<'_>),
) -> Result<()> {
    let mut reference = fixture.state.clone();
    let mut rows: Vec<Row> = Vec::new();
    for (index, step) in fixture.steps.iter().enumerate() {
        let stage = step.stage.name;
        if !takes_part(stage, stages) {
            step.reference(&mut reference);
            continue;
        }
        told(Event::Begins(stage));
        let begin = Instant::now();
        poison(&mut reference, *step);
        let ran = interpreter.run(&reference, *step, false)?;
        let mut device = reference.clone();
        ran.write(&mut device);
        step.reference(&mut reference);
        let mut row = compared_row(*step, &fixture.name, [&reference, &device]);
        let hash = |id: BufferId| (id.spec().name, hashed(SEED, device.data.bytes(id)));
        row.hashes = step.stage.results().map(hash).collect();
        row.seconds = begin.elapsed().as_secs_f64();
        row.failed = (!row.faults.is_empty()).then_some(index);
        add_row(&mut rows, row);
        let last = fixture.steps[index + 1..].iter().all(|later| later.stage.name != stage);
        rows.iter_mut().filter(|row| last && row.stage == stage).for_each(|row| told(Event::Ends(row)));
    }
    Ok(())
}

/// What the interpreter has watched, and what it has found.
#[derive(Default)]
pub struct Sanitized {
    /// How many fixtures.
    pub fixtures: usize,
    /// How many dispatches.
    pub dispatches: usize,
    /// Instructions of SPIR-V that invocations have executed.
    pub executed: u64,
    /// The kernels.
    pub kernels: BTreeSet<String>,
    /// Each thing found wrong, once for an instruction, and the fixture and step where it was found first.
    pub findings: Vec<(Finding, String)>,
    known: BTreeMap<(String, &'static str, String), usize>,
}

impl Sanitized {
    /// Runs stages of a fixture, or all if none is given, and watches them; the reference runs the others. Returns what
    /// was not found before.
    pub fn add(
        &mut self,
        interpreter: &Interpreter,
        fixture: &Fixture,
        stages: &[String],
    ) -> Result<&[(Finding, String)]> {
        let before = self.findings.len();
        let mut reference = fixture.state.clone();
        self.fixtures += 1;
        for step in &fixture.steps {
            if !takes_part(step.stage.name, stages) {
                step.reference(&mut reference);
                continue;
            }
            poison(&mut reference, *step);
            let ran = interpreter.run(&reference, *step, true)?;
            step.reference(&mut reference);
            self.dispatches += ran.dispatches;
            self.executed += ran.executed;
            self.kernels.extend(ran.kernels.iter().cloned());
            for finding in ran.findings(&reference) {
                let site: &Site = &finding.site;
                let key = (finding.kernel.clone(), finding.kind.name(), site.to_string());
                match self.known.get(&key) {
                    Some(known) => self.findings[*known].0.times += finding.times,
                    None => {
                        self.known.insert(key, self.findings.len());
                        self.findings.push((finding, format!("{step} on {}", fixture.name)));
                    }
                }
            }
        }
        Ok(&self.findings[before..])
    }
}
