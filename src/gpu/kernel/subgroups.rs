//! Which of a kernel's modules a device gets: the one that shares values in subgroups, or the one that does without.

use super::shape::Shape;
use crate::error::Result;
use crate::gpu::choices::Optimization;
use crate::gpu::logical_device::LogicalDevice;
use crate::gpu::reflect::{has_subgroups, reflect, words_of, words_without_subgroups};
use crate::gpu::replace::compiled;

impl LogicalDevice {
    /// The subgroup size that is required of kernels that shuffle, or of others; none leaves it to the driver.
    pub(in super::super) fn subgroup(&self, shuffles: bool) -> Option<u32> {
        self.choices().subgroup.or_else(|| self.adapter().narrower().filter(|_| shuffles))
    }

    /// Invocations of the subgroups in which kernels may shuffle, whose groups have so many in a row; 1 if they may
    /// not.
    pub(crate) fn subgroup_that_shuffles(&self, across: u32) -> u32 {
        let size = self.subgroup(true).unwrap_or(self.adapter().limits.subgroup_size);
        if self.grants_full_subgroups(across) { size } else { 1 }
    }

    /// Whether a kernel whose groups have this many invocations in a row gets full subgroups, and may shuffle in them:
    /// only then does an invocation's number follow from its subgroup's number and its lane in that.
    pub(in super::super) fn grants_full_subgroups(&self, across: u32) -> bool {
        let (choices, adapter) = (self.choices(), self.adapter());
        let size = self.subgroup(true).unwrap_or(adapter.limits.subgroup_size);
        let offered = adapter.offers.full_subgroups && adapter.offers.shuffles;
        offered && !choices.no_shuffles && size > 0 && across.is_multiple_of(size)
    }
}

/// The build's SPIR-V of a kernel for this device: optimised as chosen, and without subgroup operations where the
/// device does not grant full subgroups.
pub(in super::super) fn words_for(device: &LogicalDevice, name: &str) -> Result<Vec<u32>> {
    let words = words_of(name)?;
    let across = || -> Result<u32> {
        let found = reflect(name, &words)?;
        Ok(Shape::of(device, name, &found).group.unwrap_or(found.across))
    };
    let alone = has_subgroups(&words) && !device.grants_full_subgroups(across()?);
    match (alone, device.choices().optimization) {
        (false, Optimization::Performance) => Ok(words),
        (true, Optimization::Performance) => Ok(words_without_subgroups(name).unwrap_or(words)),
        (_, other) => compiled(name, other, alone),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::adapter::Adapter;
    use crate::gpu::choices::Choices;
    use crate::gpu::extras::Extras;
    use crate::gpu::instance::Instance;
    use crate::gpu::reflect::kernels_without_subgroups;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn without_full_subgroups_kernels_have_no_subgroup_operations() {
        let instance = Instance::open(false).unwrap();
        let able = |adapter: &Adapter| adapter.unusable.is_none() && adapter.offers.full_subgroups;
        let Some(adapter) = instance.adapters().unwrap().into_iter().find(able) else {
            println!("full subgroups: not tested (no device offers them)");
            return;
        };
        let size = adapter.limits.subgroup_size;
        let grouped = |size: u32| Choices { groups: [(String::new(), size)].into(), ..Choices::default() };
        for (kernel, alone) in
            kernels_without_subgroups().map(|name| (name, true)).chain([("transport/blocks/push", false)])
        {
            let with = |choices: &Choices, full: bool, shuffles: bool| {
                let mut adapter = adapter.clone();
                (adapter.offers.full_subgroups, adapter.offers.shuffles) = (full, shuffles);
                let device = LogicalDevice::open(&instance, &adapter, choices, &Extras::default()).unwrap();
                has_subgroups(&words_for(&device, kernel).unwrap())
            };
            assert!(has_subgroups(&words_of(kernel).unwrap()) == alone);
            assert!(!alone || with(&Choices::default(), true, true), "{kernel}");
            assert!(!with(&Choices::default(), false, true) && !with(&Choices::default(), true, false), "{kernel}");
            // Groups that a subgroup does not divide have a last one that is not full.
            let open = crate::gpu::group_is_open(kernel);
            assert!(!open || !with(&grouped(size / 2), true, true), "{kernel}");
        }
    }
}
