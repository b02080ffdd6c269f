//! What results say of a device.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Outcome, Verdict};
use crate::gpu::Adapter;
use crate::measure::probe::{FIXTURE, Fact, REPEAT};

/// What is known of a device.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceFacts {
    /// Its name.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// The Vulkan version.
    pub vulkan: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: String,
    /// The vendor's number.
    pub vendor_id: u32,
    /// The device's number.
    pub device_id: u32,
    /// The driver's number: `VkDriverId`.
    pub driver_id: i32,
    /// The driver's version, in an encoding of its own.
    pub driver_version: u32,
    /// The limits that matter here, by name.
    pub limits: BTreeMap<String, u64>,
    /// What its probes have found.
    #[serde(default)]
    pub probes: Vec<Fact>,
}

impl DeviceFacts {
    /// What is known of an adapter.
    #[must_use]
    pub fn new(adapter: &Adapter) -> Self {
        let limits = &adapter.limits;
        let numbers = [
            ("binding_bytes", limits.binding_bytes),
            ("allocation_bytes", limits.allocation_bytes),
            ("offset_alignment", limits.offset_alignment),
            ("storage_buffers", limits.storage_buffers.into()),
            ("push_bytes", limits.push_bytes.into()),
            ("group_invocations", limits.group_invocations.into()),
            ("groups_x", limits.groups[0].into()),
            ("groups_y", limits.groups[1].into()),
            ("subgroup_size", limits.subgroup_size.into()),
            ("round_to_nearest", limits.round_to_nearest.into()),
        ];
        Self {
            name: adapter.name.clone(),
            driver: adapter.driver.clone(),
            vulkan: adapter.version.clone(),
            kind: adapter.kind.into(),
            vendor_id: adapter.ids.vendor,
            device_id: adapter.ids.device,
            driver_id: adapter.ids.driver,
            driver_version: adapter.ids.driver_version,
            limits: numbers.map(|(name, value)| (name.to_string(), value)).into(),
            probes: Vec::new(),
        }
    }

    /// The outcome of each probe; one that is wrong fails if kernels rely on it.
    #[must_use]
    pub fn probed(&self) -> Vec<Outcome> {
        let outcome = |fact: &Fact| {
            let fails = fact.needed && !fact.right;
            Outcome {
                device: self.name.clone(),
                driver: self.driver.clone(),
                fixture: FIXTURE.into(),
                stage: fact.name.clone(),
                verdict: if fails { Verdict::Differs } else { Verdict::Conforms },
                faults: fails.then(|| format!("{}: {}", fact.what, fact.found)).into_iter().collect(),
                repeat: REPEAT.into(),
                ..Outcome::default()
            }
        };
        self.probes.iter().map(outcome).collect()
    }
}
