//! How a kernel's groups are where the device sets that: how large, and how many invocations share an item.

use super::Kernel;
#[cfg(feature = "measure")]
use crate::error::Result;
use crate::gpu::logical_device::LogicalDevice;
use crate::gpu::reflect::{Reflected, reflect};
use crate::layout::{BLOCK_RECEIVERS, GROUP_ID, LANES_ID, MOST_LANES, TEAMS_ID};

/// Groups of a kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) struct Shape {
    /// Invocations of a group, where they are set.
    pub(in super::super) group: Option<u32>,
    /// How many invocations share an item, and the constant that tells the kernel.
    shared: Option<(u32, u32)>,
}

impl Shape {
    /// The shape of this kernel on a device. Where a size is chosen for its groups, no item is shared.
    pub(in super::super) fn of(device: &LogicalDevice, name: &str, found: &Reflected) -> Self {
        match device.choices().group(name).filter(|_| found.constants.contains_key(&GROUP_ID)) {
            Some(size) => Self { group: Some(size), shared: None },
            None => Self::with_lanes(device.lanes(), found),
        }
    }

    /// The shape where as many invocations share an item, if the kernel lets them; a user's may not.
    pub(in super::super) fn with_lanes(lanes: u32, found: &Reflected) -> Self {
        let has = |id: &u32| found.constants.contains_key(id);
        let an_item = |id: u32| if id == TEAMS_ID { lanes / BLOCK_RECEIVERS as u32 } else { lanes };
        let shared = [LANES_ID, TEAMS_ID].into_iter().find(|id| lanes > 1 && has(&GROUP_ID) && has(id));
        Self { group: shared.map(|_| lanes), shared: shared.map(|id| (id, an_item(id))) }
    }

    /// How many invocations share an item, or a block's receivers: those of a group, or 1.
    pub(in super::super) fn lanes(&self) -> u32 {
        self.shared.and(self.group).unwrap_or(1)
    }

    /// How many invocations an item has.
    pub(in super::super) fn an_item(&self) -> u32 {
        self.shared.map_or(1, |(_, count)| count)
    }

    /// The specialization constants that set it.
    pub(in super::super) fn constants(&self) -> impl Iterator<Item = (u32, u32)> {
        self.group.map(|size| (GROUP_ID, size)).into_iter().chain(self.shared)
    }
}

impl Kernel {
    /// The kernel of this SPIR-V where so many invocations share an item, whatever the device is.
    #[cfg(feature = "measure")]
    pub(crate) fn with_lanes(
        device: &LogicalDevice,
        name: &str,
        words: Vec<u32>,
        constants: &[u32],
        lanes: u32,
    ) -> Result<Self> {
        let shape = Shape::with_lanes(lanes, &reflect(name, &words)?);
        Self::shaped(device, name, words, constants, shape)
    }

    /// How many invocations share an item.
    pub(crate) fn lanes(&self) -> u32 {
        self.shape.lanes()
    }
}

/// The specialization constants from `GROUP_ID` on of this SPIR-V where so many invocations share an item, with their
/// ids.
pub fn set_by_device(name: &str, words: &[u32], lanes: u32) -> Vec<(u32, u32)> {
    reflect(name, words).map_or_else(|_| Vec::new(), |found| Shape::with_lanes(lanes, &found).constants().collect())
}

impl LogicalDevice {
    /// How many invocations share an item, in kernels that can: 1 on a processor, where an invocation is a lane of a
    /// vector and waits for nothing; elsewhere as many as every device has in a group.
    fn lanes(&self) -> u32 {
        let adapter = self.adapter();
        let default = if adapter.kind == "cpu" { 1 } else { MOST_LANES };
        self.choices().lanes.unwrap_or(default).min(adapter.limits.group_invocations).min(MOST_LANES)
    }
}
