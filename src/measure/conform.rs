//! Conformance: runs every stage of a frame on the CPU and on a device, from the same state, and compares all memory.
//!
//! Before each step, both sides get poison in the memory that the stage overwrites. The CPU runs on the reference's
//! state, the device on its own copy, which starts from the same bits. Then every buffer is compared: written ones
//! within the stage's tolerance, all others bit for bit. The device runs twice and must give the same bits; the guard
//! bytes after each buffer must be untouched; the validation layer must report nothing.

use std::time::Instant;

use crate::error::Result;
use crate::geometry::{deform, placement};
use crate::gpu::Device;
use crate::layout::{BUFFER_IDS, BufferId};
pub use crate::measure::compare::BINS;
use crate::measure::compare::{Distances, compare};
use crate::measure::fixtures::Fixture;
use crate::measure::interpret::POISON;
use crate::state::{DeviceState, Role, State, Step, Tolerance};

/// The result of one stage on one fixture.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// The fixture.
    pub fixture: String,
    /// The stage.
    pub stage: &'static str,
    /// Steps compared: one per object, chunk, group or batch.
    pub steps: usize,
    /// The distances of what the stage writes.
    pub distances: Distances,
    /// Everything found wrong; empty if the stage conforms.
    pub faults: Vec<String>,
    /// Of each buffer that the stage writes, a hash of what the device left in all steps.
    pub hashes: Vec<(&'static str, u64)>,
    /// Time of the comparison by the host's clock, seconds.
    pub seconds: f64,
    /// The first of the fixture's steps in which something was found wrong.
    pub failed: Option<usize>,
}

/// A deliberate change to the device's results, to prove that the harness detects it.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    /// The stage after which the change is made.
    pub stage: &'static str,
    /// The buffer of which one word is changed.
    pub slot: BufferId,
}

/// Runs every step of a fixture and returns one row per stage. With planted errors, each is tested separately, and
/// only their stages run on the device.
pub fn conform(device: &Device, fixture: &Fixture, plants: &[Plant]) -> Result<Vec<Row>> {
    let takes_part = |stage: &str| plants.is_empty() || plants.iter().any(|plant| plant.stage == stage);
    compared(device, fixture, plants, &takes_part, &mut |_| {})
}

/// Like [`conform`], for some stages only; the other stages run on the reference alone.
pub fn conform_stages(device: &Device, fixture: &Fixture, stages: &[String]) -> Result<Vec<Row>> {
    compared(device, fixture, &[], &|stage| stages.iter().any(|name| name == stage), &mut |_| {})
}

/// What happens in a comparison.
pub enum Event<'a> {
    /// Steps of this stage begin.
    Begins(&'static str),
    /// The last step of a stage is done.
    Ends(&'a mut Row),
}

/// Like [`conform_stages`], or for all stages if none is given; tells each event when it happens.
pub fn conform_told(
    device: &Device,
    fixture: &Fixture,
    stages: &[String],
    told: &mut dyn FnMut(Event<'_>),
) -> Result<Vec<Row>> {
    let takes_part = |stage: &str| stages.is_empty() || stages.iter().any(|name| name == stage);
    compared(device, fixture, &[], &takes_part, told)
}

fn compared(
    device: &Device,
    fixture: &Fixture,
    plants: &[Plant],
    takes_part: &dyn Fn(&str) -> bool,
    told: &mut dyn FnMut(Event<'_>),
) -> Result<Vec<Row>> {
    let mut rows: Vec<Row> = Vec::new();
    let mut pair = Pair::new(device, &fixture.state)?;
    let _ = device.take_messages();
    // Steps after the last compared one have no effect on the result.
    let end = fixture.steps.iter().rposition(|step| takes_part(step.stage.name)).map_or(0, |last| last + 1);
    for (index, step) in fixture.steps[..end].iter().enumerate() {
        if !takes_part(step.stage.name) {
            step.reference(&mut pair.reference);
            pair.stale = BUFFER_IDS.to_vec();
            continue;
        }
        told(Event::Begins(step.stage.name));
        let start = Instant::now();
        for mut row in pair.step(*step, &fixture.name, plants)? {
            row.seconds = start.elapsed().as_secs_f64();
            row.failed = (!row.faults.is_empty()).then_some(index);
            add_row(&mut rows, row);
        }
        let last = fixture.steps[index + 1..end].iter().all(|later| later.stage.name != step.stage.name);
        for row in rows.iter_mut().filter(|row| last && row.stage == step.stage.name) {
            told(Event::Ends(row));
        }
    }
    Ok(rows)
}

/// Adds the row of a step to that of its stage.
pub(super) fn add_row(rows: &mut Vec<Row>, row: Row) {
    let Some(known) = rows.iter_mut().find(|known| known.stage == row.stage) else { return rows.push(row) };
    known.steps += 1;
    known.distances.add(row.distances);
    known.faults.extend(row.faults);
    known.failed = known.failed.or(row.failed);
    known.seconds += row.seconds;
    let hashes = known.hashes.iter_mut().zip(row.hashes);
    hashes.for_each(|((_, hash), (_, more))| *hash = hashed(*hash, &more.to_le_bytes()));
}

/// The hash of no bytes.
pub(super) const SEED: u64 = 0xcbf2_9ce4_8422_2325;

/// A hash of these bytes after others: FNV-1a over words.
pub(super) fn hashed(hash: u64, bytes: &[u8]) -> u64 {
    let word = |b: &[u8]| b.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte));
    bytes.chunks(4).fold(hash, |hash, b| (hash ^ word(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Fills the memory that a step overwrites with poison.
pub(super) fn poison(state: &mut State, step: Step) {
    for (slot, role, _) in step.stage.writes {
        if *role != Role::Update {
            let stride = slot.spec().stride;
            let (first, count) = state.part(*slot, step.at);
            let bytes = &mut state.data.bytes_mut(*slot)[first * stride..(first + count) * stride];
            bytemuck::cast_slice_mut::<u8, u32>(bytes).fill(POISON);
        }
    }
    // These stages overwrite their object's positions, but declare an update, since those of other objects stay.
    let places = match step.stage {
        stage if stage.is(&deform::STAGE) => &mut state.data.positions,
        stage if stage.is(&placement::STAGE) => &mut state.data.placed_positions,
        _ => return,
    };
    let object = &state.objects[step.at.object];
    places[object.first.vertices..][..object.count.vertices].fill([f32::from_bits(POISON); 3]);
}

/// Both sides of a comparison. States are large, so each is created once, and only buffers that may differ are
/// uploaded.
struct Pair {
    device_state: DeviceState,
    /// The reference's state.
    reference: State,
    /// The state last downloaded from the device.
    device: State,
    /// Buffers in which the device may differ from the reference.
    stale: Vec<BufferId>,
}

impl Pair {
    fn new(device: &Device, state: &State) -> Result<Self> {
        let device_state = DeviceState::new(device, true)?;
        Ok(Self { device_state, reference: state.clone(), device: state.clone(), stale: BUFFER_IDS.to_vec() })
    }

    /// Runs one step on both sides and returns the findings: one row, or one per error planted in this stage.
    fn step(&mut self, step: Step, name: &str, plants: &[Plant]) -> Result<Vec<Row>> {
        let written: Vec<BufferId> = step.stage.writes.iter().map(|(slot, _, _)| *slot).collect();
        poison(&mut self.reference, step);
        let size = |state: &State, slot: &BufferId| state.data.bytes(*slot).len();
        if BUFFER_IDS.iter().any(|slot| size(&self.reference, slot) != size(&self.device, slot)) {
            self.device = self.reference.clone();
        }
        self.stale.retain(|slot| !written.contains(slot));
        self.stale.extend(&written);
        self.device_state.upload(&self.reference, &self.stale)?;

        // Two runs on the device with the same inputs. All buffers are downloaded after the second run only, which
        // also shows what the first run changed outside its outputs.
        self.device_state.run(&self.reference, &[step])?;
        self.device_state.download(&mut self.device, &written)?;
        let mut first: Vec<Vec<u8>> = written.iter().map(|slot| self.device.data.bytes(*slot).to_vec()).collect();
        self.device_state.upload(&self.reference, &written)?;
        self.device_state.run(&self.reference, &[step])?;
        self.device_state.download(&mut self.device, BUFFER_IDS)?;
        let trespasses = self.device_state.trespasses(&self.reference)?;
        if !trespasses.is_empty() {
            self.device_state = DeviceState::new(self.device_state.device(), true)?;
        }
        step.reference(&mut self.reference);
        let mut rows = Vec::new();
        for plant in plants.iter().filter(|plant| plant.stage == step.stage.name) {
            self.toggle(plant.slot, &written, &mut first);
            rows.push(self.row(step, name, &first, &trespasses));
            self.toggle(plant.slot, &written, &mut first);
        }
        if plants.is_empty() {
            rows.push(self.row(step, name, &first, &trespasses));
        }
        let same = |slot: &BufferId| self.reference.data.bytes(*slot) == self.device.data.bytes(*slot);
        self.stale = BUFFER_IDS.iter().copied().filter(|slot| !trespasses.is_empty() || !same(slot)).collect();
        Ok(rows)
    }

    /// Flips one bit in the downloaded copies of this buffer, of both runs; a second call restores it.
    fn toggle(&mut self, slot: BufferId, written: &[BufferId], first: &mut [Vec<u8>]) {
        if let [word, ..] = bytemuck::cast_slice_mut::<u8, u32>(self.device.data.bytes_mut(slot)) {
            *word ^= 0x4000_0000;
            if let Some(at) = written.iter().position(|known| *known == slot) {
                first[at][..4].copy_from_slice(&word.to_ne_bytes());
            }
        }
    }

    /// Compares both sides after a step; `first` holds what the device wrote in its first run.
    fn row(&self, step: Step, name: &str, first: &[Vec<u8>], trespasses: &[&str]) -> Row {
        let mut row = compared_row(step, name, [&self.reference, &self.device]);
        for ((slot, _, _), first) in step.stage.writes.iter().zip(first) {
            if step.stage.is_scratch(*slot) {
                continue;
            }
            row.hashes.push((slot.spec().name, hashed(SEED, first)));
            if self.device.data.bytes(*slot) != first {
                row.faults.push(format!("{step} two runs differ in buffer {}", slot.spec().name));
            }
        }
        row.faults.extend(trespasses.iter().map(|name| format!("{step} wrote beyond the end of buffer {name}")));
        row.faults.extend(self.device_state.device().take_messages());
        row
    }
}

/// Compares all memory of the reference and of a device after a step.
pub(super) fn compared_row(step: Step, name: &str, [reference, device]: [&State; 2]) -> Row {
    let mut row = Row { fixture: name.to_string(), stage: step.stage.name, steps: 1, ..Row::default() };
    for &slot in BUFFER_IDS.iter().filter(|slot| !step.stage.is_scratch(**slot)) {
        let written = step.stage.writes.iter().find(|(written, _, _)| *written == slot);
        let tolerance = written.map_or(Tolerance::Exact, |(_, _, tolerance)| *tolerance);
        let found = compare(slot, reference, device, tolerance, reference.part(slot, step.at));
        if written.is_some() {
            row.distances.add(found.distances);
        }
        if found.failures > 0 {
            let what = if written.is_some() { "beyond tolerance" } else { "changed though not written" };
            let first = found.first.unwrap_or_default();
            let mut fault = format!("{step} {what}, {} words: {first}", found.failures);
            if let Some(worst) = found.worst {
                fault += &format!("; worst {worst}");
            }
            fault += &format!("; wrong: {}", found.places);
            if tolerance != Tolerance::Exact {
                fault += &format!("; the tolerance is {tolerance:?} because {}", step.stage.reason);
            }
            row.faults.push(fault);
        }
    }
    row
}
