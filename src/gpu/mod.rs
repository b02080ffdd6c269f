//! The only home of `ash` and of `unsafe`: instance, device, memory, kernels, and the recording of a frame.
//!
//! Nothing here knows what a stage or a triangle is. Handles own what they need and free themselves.

mod adapter;
mod allocator;
mod bind;
mod call;
#[cfg(feature = "shaderc")]
mod compile;
pub mod count;
mod device;
#[doc(hidden)]
pub mod faults;
mod instance;
mod kernel;
mod kernel_cache;
mod kernels;
mod logical_device;
mod memory;
mod record;
mod reflect;
mod replace;
mod single_kernel;
mod spirv_module;
mod transfer;
mod vk_error;

pub use adapter::{Adapter, Limits};
pub use allocator::MemoryUse;
pub(crate) use bind::Binding;
pub use device::Device;
pub use instance::Instance;
pub use kernel::{Kernel, KernelKey};
pub use kernels::Kernels;
pub use logical_device::LogicalDevice;
pub use memory::Buffer;
pub use record::Timing;
pub(crate) use record::{Recorder, Work};
pub use reflect::{Access, accesses, constants, kernel_names, reflect_records, spirv};
pub use replace::{replacement, source, sources};
pub use single_kernel::Alone;
pub(crate) use transfer::{BufferRange, Upload, download, upload};
