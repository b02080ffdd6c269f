//! The shape of a kernel's groups where the device decides it: their size, and how many invocations share an item.

use super::Kernel;
#[cfg(feature = "measure")]
use crate::error::Result;
use crate::gpu::logical_device::LogicalDevice;
#[cfg(feature = "measure")]
use crate::gpu::reflect::has_subgroups;
use crate::gpu::reflect::{Reflected, reflect};
use crate::layout::{
    BLOCK_RECEIVERS, CLIMBS_ID, COUNTED_ID, GROUP_ID, GROUP_SIZE, LANES_ID, MOST_LANES, MOST_WIDE, TEAMS_ID, WIDE_ID,
};

/// The shape of a kernel's groups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) struct Shape {
    /// Invocations of a group, if the device sets them.
    pub(in super::super) group: Option<u32>,
    /// Whether the size goes to `COUNTED_ID`: another kernel counts the groups.
    pub(in super::super) counted: bool,
    /// The constant that tells the kernel how many invocations share an item, and their number.
    shared: Option<(u32, u32)>,
}

impl Shape {
    /// The shape of this kernel on a device. A group size that was chosen for the kernel turns sharing off.
    pub(in super::super) fn of(device: &LogicalDevice, name: &str, found: &Reflected) -> Self {
        match device.choices().group(name).filter(|_| found.constants.contains_key(&GROUP_ID)) {
            Some(size) => Self { group: Some(size), ..Self::default() },
            None if found.constants.contains_key(&WIDE_ID) => Self::with_lanes(device.widest(), found),
            // llvmpipe of Mesa 22.3 loses some of the invocations that climb.
            None if found.constants.contains_key(&CLIMBS_ID) && device.adapter().is_llvmpipe() => Self::default(),
            None => Self::with_lanes(device.lanes().min(most_lanes(name)), found),
        }
    }

    /// The shape with `lanes` invocations for each item, or one where the kernel has no constant for it, as a user's
    /// may not. Groups that another kernel counts have at least their usual size.
    pub(in super::super) fn with_lanes(lanes: u32, found: &Reflected) -> Self {
        let has = |id: u32| found.constants.contains_key(&id);
        let teams = |group: u32| Some((group, (TEAMS_ID, group / BLOCK_RECEIVERS as u32)));
        let shared = match lanes > 1 {
            true if has(WIDE_ID) => Some((lanes, (WIDE_ID, lanes))),
            true if has(TEAMS_ID) && has(COUNTED_ID) => teams(lanes.max(GROUP_SIZE)),
            true if has(TEAMS_ID) => teams(if has(GROUP_ID) { lanes } else { GROUP_SIZE }),
            true if has(GROUP_ID) && has(LANES_ID) => Some((lanes, (LANES_ID, lanes))),
            true if has(GROUP_ID) && has(CLIMBS_ID) => Some((GROUP_SIZE, (CLIMBS_ID, 1))),
            _ => None,
        };
        let counted = has(COUNTED_ID);
        Self { group: shared.map(|(group, _)| group), shared: shared.map(|(_, constant)| constant), counted }
    }

    /// Invocations of a group if items are shared, else 1.
    pub(in super::super) fn lanes(&self) -> u32 {
        self.shared.and(self.group).unwrap_or(1)
    }

    /// Invocations that share an item, or a receiver of a block.
    pub(in super::super) fn an_item(&self) -> u32 {
        self.shared.map_or(1, |(_, count)| count)
    }

    /// The specialization constants that set it.
    pub(in super::super) fn constants(&self) -> impl Iterator<Item = (u32, u32)> {
        let id = if self.counted { COUNTED_ID } else { GROUP_ID };
        self.group.map(|size| (id, size)).into_iter().chain(self.shared)
    }
}

/// The most invocations that share an item of this kernel. A block has some 150 distant emitters, so that more
/// than 32 invocations seldom have a run each: 48 us with 128, 35 with 32 (H200, a bunny of 69,451 faces). The
/// bisection of a table's entry takes 5 steps at once with 32, and 7 with 128, which is four times the work.
pub(crate) fn most_lanes(name: &str) -> u32 {
    if name.ends_with("/expand") || name.ends_with("/table") { 32 } else { MOST_LANES }
}

impl Kernel {
    /// The kernel of this SPIR-V with `lanes` invocations for each item, whatever this device would choose.
    #[cfg(feature = "measure")]
    pub(crate) fn with_lanes(
        device: &LogicalDevice,
        name: &str,
        words: Vec<u32>,
        constants: &[u32],
        lanes: u32,
    ) -> Result<Self> {
        let found = reflect(name, &words)?;
        // A kernel of one group has the same bits at any width; this device may not have groups as wide as another's.
        let wide = found.constants.contains_key(&WIDE_ID) && lanes > 1;
        let shape = Shape::with_lanes(if wide { lanes.min(device.most_in_group()) } else { lanes }, &found);
        let shuffles = has_subgroups(&words);
        Self::shaped(device, name, words, constants, (shape, shuffles))
    }

    /// How many invocations share an item.
    pub(crate) fn lanes(&self) -> u32 {
        self.shape.lanes()
    }
}

/// The specialization constants that a device sets, from `GROUP_ID` on, with `lanes` invocations for each item: ids and
/// values.
pub fn set_by_device(name: &str, words: &[u32], lanes: u32) -> Vec<(u32, u32)> {
    reflect(name, words).map_or_else(|_| Vec::new(), |found| Shape::with_lanes(lanes, &found).constants().collect())
}

impl LogicalDevice {
    /// How many invocations share an item, in kernels that can: 1 on a processor, where an invocation is a lane of a
    /// vector and waits for nothing; elsewhere as many as every device has in a group.
    pub(crate) fn lanes(&self) -> u32 {
        let adapter = self.adapter();
        let default = if adapter.kind == "cpu" { 1 } else { MOST_LANES };
        self.choices().lanes.unwrap_or(default).min(adapter.limits.group_invocations).min(MOST_LANES)
    }

    /// The size of a group that works through all elements alone: the largest where items are shared; 1 leaves it to
    /// the kernel.
    fn widest(&self) -> u32 {
        if self.lanes() > 1 { self.most_in_group() } else { 1 }
    }

    /// The largest size of such a group: a power of two.
    fn most_in_group(&self) -> u32 {
        1 << self.adapter().limits.group_invocations.clamp(1, MOST_WIDE).ilog2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::reflect::words_of;

    #[test]
    fn kernels_share_items_as_their_constants_say() {
        let shape =
            |name: &str, lanes: u32| Shape::with_lanes(lanes, &reflect(name, &words_of(name).unwrap()).unwrap());
        // Groups of this size, so many invocations an item, and the constant that says so.
        for (name, group, constant) in [
            ("transport/blocks/link/count", 128, (LANES_ID, 128)),
            ("transport/blocks/link/scan", 128, (WIDE_ID, 128)),
            ("transport/diffusion/boundary_integrals/expand", 128, (LANES_ID, 128)),
            ("transport/blocks/gather/direct", 128, (TEAMS_ID, 8)),
            ("transport/diffusion/boundary_integrals/direct", 128, (TEAMS_ID, 8)),
            ("transport/blocks/gather/edge", 128, (TEAMS_ID, 8)),
            ("transport/diffusion/boundary_integrals/edge", 128, (TEAMS_ID, 8)),
            ("transport/blocks/pull/cluster", GROUP_SIZE, (CLIMBS_ID, 1)),
        ] {
            let shared = shape(name, 128);
            assert_eq!((shared.group, shared.shared), (Some(group), Some(constant)), "{name}");
            assert_eq!((shared.lanes(), shared.an_item()), (group, constant.1), "{name}");
            assert_eq!((shape(name, 1).group, shape(name, 1).shared), (None, None), "{name}");
        }
        let counted = shape("transport/blocks/gather/edge", 32);
        assert_eq!((counted.group, counted.shared), (Some(GROUP_SIZE), Some((TEAMS_ID, 4))));
        let alone = "transport/diffusion/boundary_integrals/source_edge";
        assert_eq!(shape(alone, 128), Shape::default());
    }
}
