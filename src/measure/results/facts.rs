//! What results say of a device and its system.

use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::fs::read_to_string;

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
    /// The results of its probes.
    #[serde(default)]
    pub probes: Vec<Fact>,
}

/// The operating system and the processor, as the system tells them.
#[must_use]
pub fn system() -> String {
    let value = |file: &str, key: &str, sign: char| -> Option<String> {
        let text = read_to_string(file).ok()?;
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.trim_start().strip_prefix(sign))?;
        Some(line.trim().trim_matches('"').to_string())
    };
    let name = value("/etc/os-release", "PRETTY_NAME", '=').unwrap_or_else(|| OS.into());
    let processor = value("/proc/cpuinfo", "model name", ':').map_or_else(String::new, |model| format!(", {model}"));
    format!("{name}, {ARCH}{processor}")
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

    /// The device as a bug report names it.
    #[must_use]
    pub fn device(&self) -> String {
        let size = self.limits.get("subgroup_size").copied().unwrap_or(0);
        format!("{} ({:#06x}:{:#06x}), subgroups of {size}", self.name, self.vendor_id, self.device_id)
    }

    /// The driver as a bug report names it.
    #[must_use]
    pub fn own_driver(&self) -> String {
        format!("{} (version {:#x}, Vulkan {})", self.driver, self.driver_version, self.vulkan)
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
