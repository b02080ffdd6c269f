//! What a scene's buffers hold after some frames, and whether another use of the API leaves the same in them.

use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::{BUFFER_IDS, BufferId};
use crate::measure::conform::conform;
use crate::measure::fixtures::Fixture;
use crate::measure::profile::Settings;
use crate::pipeline::frame::STAGES;
use crate::scene::Scene;
use crate::session::run::Session;
use crate::state::{DeviceState, State};

/// The buffers after a first frame and two more.
pub struct Computed(Vec<(BufferId, Vec<u8>)>);

/// What was proved of a variant.
#[derive(Clone, Debug)]
pub enum Proof {
    /// Every buffer is bit for bit the default's.
    Same {
        /// How many buffers there are.
        buffers: usize,
        /// Their size in bytes.
        bytes: usize,
    },
    /// Some buffers have other bits, but every stage conforms to the reference.
    Conforms {
        /// Names of the buffers that differ.
        differ: Vec<&'static str>,
        /// For each stage the largest difference to the reference, as a share of the allowed one.
        used: Vec<(&'static str, f64)>,
    },
}

impl std::fmt::Display for Proof {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Same { buffers, bytes } => {
                let size = *bytes as f64 / 1_048_576.0;
                write!(out, "bit for bit the default's: {buffers} buffers of {size:.1} MiB after 3 frames")
            }
            Self::Conforms { differ, used } => {
                write!(out, "other bits in {} buffers ({}); every stage conforms", differ.len(), differ.join(", "))?;
                match used.iter().max_by(|one, two| one.1.total_cmp(&two.1)) {
                    Some((stage, used)) => write!(out, ", {stage} with {:.0} % of what is allowed", 100.0 * used),
                    None => Ok(()),
                }
            }
        }
    }
}

/// Runs frames of a scene on a device, and reads all buffers.
pub(super) fn computed(scene: &Scene, device: &Device, settings: &Settings) -> Result<Computed> {
    let mut session = Session::new(scene, Some(device), settings.options)?;
    session.frame(crate::pipeline::plan::Change::EVERYTHING)?;
    for _ in 0..2 {
        session.frame(settings.change)?;
    }
    session.fetch(BUFFER_IDS)?;
    Ok(Computed::of(session.state()))
}

/// Runs the steps of a fixture twice on a device, all in one frame, and reads all buffers.
pub fn computed_steps(device: &Device, fixture: &Fixture) -> Result<Computed> {
    let mut state = fixture.state.clone();
    let mut copy = DeviceState::new(device, false)?;
    copy.upload(&state, BUFFER_IDS)?;
    for _ in 0..2 {
        copy.run(&state, &fixture.steps)?;
    }
    copy.download(&mut state, BUFFER_IDS)?;
    Ok(Computed::of(&state))
}

impl Computed {
    /// All buffers but those that stages keep for themselves.
    fn of(state: &State) -> Self {
        let scratch = |slot: BufferId| STAGES.iter().any(|stage| stage.is_scratch(slot));
        let compared = BUFFER_IDS.iter().filter(|slot| !scratch(**slot));
        Self(compared.map(|slot| (*slot, state.data.bytes(*slot).to_vec())).collect())
    }

    /// The buffers that hold something else.
    fn differ(&self, other: &Self) -> Vec<BufferId> {
        let pairs = self.0.iter().zip(&other.0);
        pairs.filter(|((_, one), (_, two))| one != two).map(|((slot, _), _)| *slot).collect()
    }

    /// The first difference in a buffer, in words.
    fn first(&self, other: &Self, slot: BufferId) -> String {
        let bytes = |all: &Self| all.0.iter().find(|(known, _)| *known == slot).map(|(_, bytes)| bytes.clone());
        let (one, two) = (bytes(self).unwrap_or_default(), bytes(other).unwrap_or_default());
        let name = slot.spec().name;
        if one.len() != two.len() {
            return format!("buffer {name} has {} bytes instead of {}", two.len(), one.len());
        }
        let word = |bytes: &[u8]| bytes.iter().rev().fold(0u32, |all, byte| all << 8 | u32::from(*byte));
        let mut words = one.chunks(4).zip(two.chunks(4)).enumerate().filter(|(_, (one, two))| one != two);
        let count = words.clone().count();
        words.next().map_or_else(String::new, |(at, (one, two))| {
            let (one, two) = (word(one), word(two));
            format!(
                "buffer {name} differs in {count} words; the first is word {at}, {two:#010x} instead of {one:#010x}"
            )
        })
    }
}

/// Compares what a variant computed with what the default did. Fails where they differ, unless other arithmetic was
/// chosen and every stage of the fixture conforms on the variant's device.
pub fn proof(
    name: &str,
    [default, variant]: [&Computed; 2],
    device: &Device,
    fixture: &dyn Fn() -> Result<Fixture>,
) -> Result<Proof> {
    let differ = default.differ(variant);
    let Some(first) = differ.first() else {
        let bytes = default.0.iter().map(|(_, bytes)| bytes.len()).sum();
        return Ok(Proof::Same { buffers: default.0.iter().filter(|(_, bytes)| !bytes.is_empty()).count(), bytes });
    };
    let fault =
        |what: String| Error::Check(format!("{name} computes something else, so that it was not timed: {what}"));
    if device.choices().optimization == crate::gpu::Optimization::default() {
        return Err(fault(default.first(variant, *first)));
    }
    // Messages up to here are the variant's own; `conform` takes those of its comparison.
    if let Some(message) = device.take_messages().first() {
        return Err(Error::Check(format!("{name}: the validation layer: {message}")));
    }
    let rows = conform(device, &fixture()?, &[])?;
    if let Some((stage, what)) = rows.iter().find_map(|row| Some((row.stage, row.faults.first()?))) {
        return Err(fault(format!("stage {stage}: {what}")));
    }
    let used = rows.iter().map(|row| (row.stage, row.distances.used)).collect();
    Ok(Proof::Conforms { differ: differ.iter().map(|slot| slot.spec().name).collect(), used })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_that_differs_is_named() {
        let holding = |radiosity: [u32; 3]| {
            let bytes = radiosity.iter().flat_map(|word| word.to_le_bytes()).collect();
            Computed(vec![(BufferId::irradiance, vec![1, 2, 3, 4]), (BufferId::radiosity, bytes)])
        };
        let (one, two) = (holding([1, 2, 3]), holding([1, 7, 9]));
        assert!(one.differ(&holding([1, 2, 3])).is_empty());
        assert_eq!(one.differ(&two), [BufferId::radiosity]);
        let told = one.first(&two, BufferId::radiosity);
        assert_eq!(told, "buffer radiosity differs in 2 words; the first is word 1, 0x00000007 instead of 0x00000002");
        let shorter = Computed(vec![(BufferId::irradiance, vec![1, 2, 3, 4]), (BufferId::radiosity, vec![0; 8])]);
        assert_eq!(one.first(&shorter, BufferId::radiosity), "buffer radiosity has 8 bytes instead of 12");
    }
}
