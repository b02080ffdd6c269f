//! The only home of `ash` and of `unsafe`: instance, device, memory, kernels, and the recording of a frame.
//!
//! Nothing here knows what a stage or a triangle is. Handles own what they need and free themselves.

mod alone;
mod bind;
#[cfg(feature = "shaderc")]
mod compile;
pub mod count;
mod device;
mod instance;
mod kernel;
mod memory;
mod record;
mod reflect;
mod replace;

pub use alone::Alone;
pub(crate) use bind::Binding;
pub use device::Device;
pub use instance::{Adapter, Instance, Limits};
pub use kernel::{Kernel, Kernels};
pub use memory::Buffer;
pub use record::Timing;
pub(crate) use record::{Recorder, Work};
pub use reflect::{Access, accesses, constants, kernel_names, reflect_records, spirv};
pub use replace::{replacement, source, sources};

use ash::vk;

use crate::error::Error;

/// A Vulkan result code in words, as the user can act on it.
fn fault(doing: &str, code: vk::Result) -> Error {
    let what = match code {
        vk::Result::ERROR_DEVICE_LOST => "the device was lost: its driver crashed, hung or was reset".to_string(),
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => "the device is out of memory".to_string(),
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => "the host is out of memory".to_string(),
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => "no installed driver supports Vulkan 1.2".to_string(),
        vk::Result::ERROR_INITIALIZATION_FAILED => "the driver failed to start".to_string(),
        vk::Result::ERROR_LAYER_NOT_PRESENT => {
            "the validation layer is not installed (Debian: vulkan-validationlayers)".to_string()
        }
        vk::Result::ERROR_EXTENSION_NOT_PRESENT => "the driver lacks an extension that was asked for".to_string(),
        vk::Result::ERROR_FEATURE_NOT_PRESENT => "the driver lacks a feature that was asked for".to_string(),
        other => format!("the driver answered {other:?}"),
    };
    Error::device(doing, what)
}
