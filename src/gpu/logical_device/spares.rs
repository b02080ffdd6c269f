//! Objects that a submission has used and the next one uses again. To make a fence and destroy it takes NVIDIA's driver
//! half a millisecond on a virtual machine.

use ash::vk;

use super::LogicalDevice;
use crate::error::Result;
use crate::gpu::call::vk_call;

/// Maximum number of objects of a kind that are kept.
const MOST_KEPT: usize = 16;

/// Objects that nothing uses at the moment.
#[derive(Default)]
pub(super) struct Spares {
    /// Fences, not signalled.
    fences: Vec<vk::Fence>,
    /// Pools of timestamp queries, and how many each has.
    queries: Vec<(vk::QueryPool, u32)>,
    /// Empty pools of descriptor sets, all made for the device's choices.
    sets: Vec<vk::DescriptorPool>,
}

impl LogicalDevice {
    /// A fence that is not signalled.
    pub(super) fn fence(&self, doing: &str) -> Result<vk::Fence> {
        let spare = self.0.spares.borrow_mut().fences.pop();
        spare.map_or_else(
            || {
                // SAFETY: the device is alive; the fence is kept or destroyed after use.
                vk_call("vkCreateFence", doing, || unsafe {
                    self.0.raw.create_fence(&vk::FenceCreateInfo::default(), None)
                })
                .inspect(|fence| self.label(*fence, "end of a submission"))
            },
            Ok,
        )
    }

    /// Keeps a fence that nothing will signal any more.
    pub(super) fn keep_fence(&self, fence: vk::Fence) {
        let (raw, fences) = (&self.0.raw, &mut self.0.spares.borrow_mut().fences);
        // SAFETY: no submission has the fence.
        unsafe {
            let reset = vk_call("vkResetFences", "keeping a fence", || raw.reset_fences(&[fence]));
            match reset {
                Ok(()) if fences.len() < MOST_KEPT => fences.push(fence),
                _ => raw.destroy_fence(fence, None),
            }
        }
    }

    /// A pool of at least this many timestamp queries, and how many it has.
    pub(in super::super) fn queries(&self, count: u32, doing: &str) -> Result<(vk::QueryPool, u32)> {
        let mut spares = self.0.spares.borrow_mut();
        if let Some(at) = spares.queries.iter().position(|(_, size)| *size >= count) {
            return Ok(spares.queries.swap_remove(at));
        }
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: the device is alive; the pool is kept or destroyed after use.
        let made = vk_call("vkCreateQueryPool", doing, || unsafe { self.0.raw.create_query_pool(&info, None) })?;
        self.label(made, "times of steps");
        Ok((made, count))
    }

    /// Keeps a pool of queries that nothing uses any more.
    pub(in super::super) fn keep_queries(&self, pool: (vk::QueryPool, u32)) {
        let queries = &mut self.0.spares.borrow_mut().queries;
        match queries.len() < MOST_KEPT {
            true => queries.push(pool),
            // SAFETY: no submission has it.
            false => unsafe { self.0.raw.destroy_query_pool(pool.0, None) },
        }
    }

    /// An empty pool of descriptor sets, if one is kept.
    pub(in super::super) fn spare_sets(&self) -> Option<vk::DescriptorPool> {
        self.0.spares.borrow_mut().sets.pop()
    }

    /// Keeps a pool of descriptor sets that nothing uses any more.
    pub(in super::super) fn keep_sets(&self, pool: vk::DescriptorPool) {
        let (raw, sets) = (&self.0.raw, &mut self.0.spares.borrow_mut().sets);
        // SAFETY: no submission has a set of it.
        unsafe {
            let empty = || raw.reset_descriptor_pool(pool, vk::DescriptorPoolResetFlags::empty());
            match vk_call("vkResetDescriptorPool", "keeping a pool of descriptor sets", empty) {
                Ok(()) if sets.len() < MOST_KEPT => sets.push(pool),
                _ => raw.destroy_descriptor_pool(pool, None),
            }
        }
    }
}

impl Spares {
    /// Destroys all spare objects.
    pub(super) fn destroy(&mut self, raw: &ash::Device) {
        // SAFETY: nothing uses them, and each is of this device.
        unsafe {
            self.fences.drain(..).for_each(|fence| raw.destroy_fence(fence, None));
            self.queries.drain(..).for_each(|(pool, _)| raw.destroy_query_pool(pool, None));
            self.sets.drain(..).for_each(|pool| raw.destroy_descriptor_pool(pool, None));
        }
    }
}
