//! The pipeline cache of a device.

use ash::vk;

use super::LogicalDevice;
use crate::error::Result;
use crate::gpu::call::vk_call;
use crate::gpu::choices::Cache;

impl LogicalDevice {
    /// Replaces the pipeline cache by one with this content, which a driver ignores if it is not its own.
    pub(crate) fn renew_pipeline_cache(&self, content: &[u8]) -> Result<()> {
        if self.0.choices.cache == Cache::Without {
            return Ok(());
        }
        let info = vk::PipelineCacheCreateInfo::default().initial_data(content);
        // SAFETY: the device is alive; no pipeline is being made from the old cache.
        let new = vk_call("vkCreatePipelineCache", "making a pipeline cache", || unsafe {
            self.0.raw.create_pipeline_cache(&info, None)
        })?;
        self.label(new, "pipelines");
        let old = self.0.pipeline_cache.replace(new);
        // SAFETY: pipelines do not need the cache that they were made from.
        unsafe { self.0.raw.destroy_pipeline_cache(old, None) };
        Ok(())
    }

    /// The content of the pipeline cache.
    #[cfg(feature = "measure")]
    pub(crate) fn pipeline_cache_content(&self) -> Result<Vec<u8>> {
        // SAFETY: the cache is alive, or there is none.
        vk_call("vkGetPipelineCacheData", "reading the pipeline cache", || unsafe {
            match self.pipeline_cache() {
                cache if cache == vk::PipelineCache::null() => Ok(Vec::new()),
                cache => self.0.raw.get_pipeline_cache_data(cache),
            }
        })
    }

    pub(in super::super) fn pipeline_cache(&self) -> vk::PipelineCache {
        self.0.pipeline_cache.get()
    }
}
