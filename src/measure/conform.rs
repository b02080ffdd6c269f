//! Conformance: every stage of a frame on the CPU and on a device, from the same state, and all memory compared.
//!
//! For each step the reference's state is cloned, what the stage overwrites is poisoned on both sides, the CPU runs
//! on one clone and the device on the other. Every buffer is then compared: written ones within the stage's
//! tolerance, all others bit for bit. The device runs twice and must give the same bits; guard bytes after each
//! buffer must be untouched; the validation layer must be silent.

use crate::error::Result;
use crate::gpu::Device;
use crate::layout::{SLOTS, Slot};
pub use crate::measure::compare::BINS;
use crate::measure::compare::{Comparison, compare};
use crate::measure::fixtures::Fixture;
use crate::state::{DeviceState, Role, State, Step, Tolerance};

/// What poisoned words hold: not a number as a float, far beyond any index as an integer.
const POISON: u32 = 0xffc0_dead;

/// The outcome of one stage on one fixture.
#[derive(Clone, Debug)]
pub struct Row {
    /// The fixture.
    pub fixture: String,
    /// The stage.
    pub stage: &'static str,
    /// Steps compared (chunks).
    pub steps: usize,
    /// Words compared.
    pub words: usize,
    /// Largest distance in units in the last place.
    pub ulp: u64,
    /// Floats written, by their distance: a bin for each of [`BINS`], and one for all beyond.
    pub histogram: [u64; 8],
    /// Largest relative difference.
    pub relative: f64,
    /// Everything that is wrong; empty when the stage conforms.
    pub faults: Vec<String>,
}

/// A deliberate change to the device's results, to prove that the harness sees it.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    /// After this stage ...
    pub stage: &'static str,
    /// ... in this buffer, one word is changed.
    pub slot: Slot,
}

/// Runs every step of a fixture; one row a stage. With a planted error, only its stage runs on the device.
pub fn conform(device: &Device, fixture: &Fixture, plant: Option<Plant>) -> Result<Vec<Row>> {
    compared(device, fixture, plant, &|stage| plant.is_none_or(|plant| plant.stage == stage))
}

/// The same for some stages only; the reference alone runs the others.
pub fn conform_stages(device: &Device, fixture: &Fixture, stages: &[String]) -> Result<Vec<Row>> {
    compared(device, fixture, None, &|stage| stages.iter().any(|name| name == stage))
}

fn compared(
    device: &Device,
    fixture: &Fixture,
    plant: Option<Plant>,
    takes_part: &dyn Fn(&str) -> bool,
) -> Result<Vec<Row>> {
    let mut rows: Vec<Row> = Vec::new();
    let mut twin = DeviceState::new(device, true)?;
    let mut state = fixture.state.clone();
    let _ = device.take_messages();
    // What comes after the last that takes part shows nothing more.
    let end = fixture.steps.iter().rposition(|step| takes_part(step.stage.name)).map_or(0, |last| last + 1);
    for step in &fixture.steps[..end] {
        if !takes_part(step.stage.name) {
            step.reference(&mut state);
            continue;
        }
        let (next, row) = one(&mut twin, &state, *step, &fixture.name, plant)?;
        state = next;
        match rows.iter_mut().find(|known| known.stage == row.stage) {
            Some(known) => {
                known.steps += 1;
                known.words += row.words;
                known.ulp = known.ulp.max(row.ulp);
                known.histogram.iter_mut().zip(row.histogram).for_each(|(sum, count)| *sum += count);
                known.relative = known.relative.max(row.relative);
                known.faults.extend(row.faults);
            }
            None => rows.push(row),
        }
    }
    Ok(rows)
}

/// Poisons what a step overwrites.
fn poison(state: &mut State, step: Step) {
    for (slot, role, _) in step.stage.writes {
        if *role == Role::Output {
            let stride = slot.spec().stride;
            let (first, count) = state.part(*slot, step.at);
            let bytes = &mut state.data.bytes_mut(*slot)[first * stride..(first + count) * stride];
            bytemuck::cast_slice_mut::<u8, u32>(bytes).fill(POISON);
        }
    }
}

/// Runs one step on both sides; returns the reference's state after it, and what was found.
fn one(twin: &mut DeviceState, before: &State, step: Step, name: &str, plant: Option<Plant>) -> Result<(State, Row)> {
    let mut poisoned = before.clone();
    poison(&mut poisoned, step);
    let mut reference = poisoned.clone();
    step.reference(&mut reference);

    // Twice on the device, from the same bits.
    let mut results = Vec::new();
    for _ in 0..2 {
        twin.upload(&poisoned, SLOTS)?;
        twin.run(&poisoned, &[step])?;
        let mut result = poisoned.clone();
        twin.download(&mut result, SLOTS)?;
        results.push(result);
    }
    let trespasses = twin.trespasses(&poisoned)?;
    if let Some(plant) = plant.filter(|plant| plant.stage == step.stage.name)
        && let [word, ..] = bytemuck::cast_slice_mut::<u8, u32>(results[0].data.bytes_mut(plant.slot))
    {
        *word ^= 0x4000_0000;
        let copy = *word;
        if let [word, ..] = bytemuck::cast_slice_mut::<u8, u32>(results[1].data.bytes_mut(plant.slot)) {
            *word = copy;
        }
    }

    let mut row = Row {
        fixture: name.to_string(),
        stage: step.stage.name,
        steps: 1,
        words: 0,
        ulp: 0,
        histogram: [0; 8],
        relative: 0.0,
        faults: Vec::new(),
    };
    for &slot in SLOTS {
        let written = step.stage.writes.iter().find(|(written, _, _)| *written == slot);
        let tolerance = written.map_or(Tolerance::Exact, |(_, _, tolerance)| *tolerance);
        let found: Comparison = compare(slot, &reference, &results[0], tolerance);
        if written.is_some() {
            row.words += found.words;
            row.ulp = row.ulp.max(found.ulp);
            row.histogram.iter_mut().zip(found.histogram).for_each(|(sum, count)| *sum += count);
            row.relative = row.relative.max(found.relative);
        }
        if found.failures > 0 {
            let what = if written.is_some() { "beyond tolerance" } else { "changed though not written" };
            let first = found.first.unwrap_or_default();
            let mut fault = format!("{step:?} {what}, {} of {} words: {first}", found.failures, found.words);
            if tolerance != Tolerance::Exact {
                fault += &format!("; the tolerance is {tolerance:?} because {}", step.stage.reason);
            }
            row.faults.push(fault);
        }
        if results[0].data.bytes(slot) != results[1].data.bytes(slot) {
            row.faults.push(format!("{step:?} two runs differ in buffer {}", slot.spec().name));
        }
    }
    row.faults.extend(trespasses.iter().map(|name| format!("{step:?} wrote beyond the end of buffer {name}")));
    row.faults.extend(twin.device().take_messages());
    Ok((reference, row))
}
