//! Instance, device, memory, kernels, and the recording of a frame: the only place that uses `ash` and `unsafe`.
//!
//! Nothing here knows what a stage or a triangle is. Handles own what they need and free themselves. No file uses one
//! that is above it; from the bottom up:
//!
//! - `adapter`, `vk_error`, `faults`, `call`: what a machine offers, and calls that can fail;
//! - `instance`, `allocator`, `spirv_module`, `extras`, `logical_device`: Vulkan, a device's memory, what it is opened
//!   with, its queue and submissions;
//! - `memory`, `transfer`: buffers, and copies between host and device;
//! - `reflect`, `replace`, `compile`, [`count`]: SPIR-V, what a kernel binds, and kernels that count;
//! - `kernel`, `bind`, `record`: pipelines, descriptor sets, and a frame's dispatches and barriers;
//! - `interface`, `shift`: SPIR-V from files, and kernels whose groups count from another one;
//! - `kernel_cache`, `device`, `driver_facts`, `kernels`, `single_kernel`: what the rest of the program asks for.

mod adapter;
mod allocator;
mod bind;
mod call;
#[cfg(feature = "shaderc")]
mod compile;
pub mod count;
mod device;
mod driver_facts;
mod extras;
#[doc(hidden)]
pub mod faults;
mod instance;
#[cfg(feature = "measure")]
mod interface;
mod kernel;
mod kernel_cache;
mod kernels;
mod logical_device;
mod memory;
mod record;
mod reflect;
mod replace;
#[cfg(feature = "measure")]
mod shift;
mod single_kernel;
mod spirv_module;
mod transfer;
mod vk_error;

pub use adapter::{Adapter, Ids, Limits};
pub use allocator::MemoryUse;
pub(crate) use bind::Binding;
pub use device::Device;
pub use driver_facts::{COUNTERS, STATISTICS, Statistic};
pub use instance::Instance;
#[cfg(feature = "measure")]
pub(crate) use interface::{disassembled, interface};
pub use kernel::{Kernel, KernelKey};
pub use kernels::Kernels;
pub use logical_device::LogicalDevice;
pub use memory::Buffer;
pub use record::Timing;
pub(crate) use record::{Recorder, Work};
pub use reflect::{Access, accesses, constants, kernel_names, reflect_records, spirv};
pub use replace::{replacement, source, sources};
#[cfg(feature = "measure")]
pub(crate) use shift::shifted;
pub use single_kernel::SingleKernel;
pub(crate) use transfer::{BufferRange, Upload, download, upload};
