//! How a kernel's groups are where the device sets that: how large, and how many invocations share an item.

use crate::gpu::logical_device::LogicalDevice;
use crate::gpu::reflect::Reflected;
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
    /// The shape of this kernel on a device.
    pub(in super::super) fn of(device: &LogicalDevice, name: &str, found: &Reflected) -> Self {
        let has = |id: &u32| found.constants.contains_key(id);
        let lanes = device.lanes();
        let an_item = |id: u32| if id == TEAMS_ID { lanes / BLOCK_RECEIVERS as u32 } else { lanes };
        let shared = [LANES_ID, TEAMS_ID].into_iter().find(|id| lanes > 1 && has(id)).map(|id| (id, an_item(id)));
        let group = if shared.is_some() { Some(lanes) } else { device.choices().group(name) };
        Self { group: group.filter(|_| has(&GROUP_ID)), shared }
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

impl LogicalDevice {
    /// How many invocations share an item, in kernels that can: 1 on a processor, where an invocation is a lane of a
    /// vector and waits for nothing; elsewhere as many as every device has in a group.
    fn lanes(&self) -> u32 {
        let adapter = self.adapter();
        let default = if adapter.kind == "cpu" { 1 } else { MOST_LANES };
        self.choices().lanes.unwrap_or(default).min(adapter.limits.group_invocations).min(MOST_LANES)
    }
}
