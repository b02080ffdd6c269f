//! What a device is opened with beyond what the program's own kernels need.

use ash::{khr, vk};

/// What a device is opened with on request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Extras {
    /// Whether pipelines keep what the driver's compiler says of them; the driver has to offer that.
    pub(super) statistics: bool,
}

/// Features as structs that a call fills, or that a device is opened with.
pub(super) struct Features {
    pub(super) twelve: vk::PhysicalDeviceVulkan12Features<'static>,
    pub(super) statistics: vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR<'static>,
}

impl Extras {
    /// The features of a device with these extras; those of extensions only go with [`Self::extensions`].
    pub(super) fn features(&self) -> Features {
        Features {
            twelve: vk::PhysicalDeviceVulkan12Features::default().scalar_block_layout(true),
            statistics: vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
                .pipeline_executable_info(self.statistics),
        }
    }

    /// The extensions of a device with these extras.
    pub(super) fn extensions(&self) -> Vec<*const std::ffi::c_char> {
        let name = khr::pipeline_executable_properties::NAME.as_ptr();
        if self.statistics { vec![name] } else { Vec::new() }
    }
}
