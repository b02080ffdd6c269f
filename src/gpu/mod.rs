//! Instance, device, memory, kernels, and the recording of a frame: the only place that uses `ash` and `unsafe`.
//!
//! Nothing here knows what a stage or a triangle is. Handles own what they need and free themselves. No file uses one
//! that is above it; from the bottom up:
//!
//! - `choices`: how the API is used, and how else it could be;
//! - `offers`, `adapter`, `vk_error`, `faults`, `call`: what a machine offers, and calls that can fail;
//! - `instance`, `allocator`, `spirv_module`, `extras`, `logical_device`: Vulkan, a device's memory, what it is opened
//!   with, its queue and submissions;
//! - `memory`, `transfer`: buffers, and copies between host and device;
//! - `reflect`, `replace`, `compile`, [`count`]: SPIR-V, what a kernel binds, and kernels that count;
//! - `pushed`, `kernel`, `bind`, `list`: pipelines, and a frame as a list of dispatches;
//! - `order`, `sets`, `encode`, `first_use`, `record`: the list's barriers and descriptor sets, the list in command
//!   buffers, its new kernels, and what makes the list;
//! - `interface`, `shift`: SPIR-V from files, and kernels whose groups count from another one;
//! - `kernel_cache`, `device`, `execution`, `driver_facts`, `kernels`, `single_kernel`: what the rest of the program
//!   asks for, and whether a device executes it at all;
//! - `window`: pictures in a window (feature `window`).

mod adapter;
mod allocator;
mod bind;
mod call;
mod choices;
#[cfg(feature = "shaderc")]
mod compile;
pub mod count;
mod device;
mod driver_facts;
mod encode;
mod execution;
mod extras;
#[doc(hidden)]
pub mod faults;
mod first_use;
mod instance;
#[cfg(feature = "measure")]
mod interface;
mod kernel;
mod kernel_cache;
mod kernels;
mod list;
mod logical_device;
mod memory;
mod offers;
mod order;
mod pushed;
mod record;
mod reflect;
mod replace;
mod sets;
#[cfg(feature = "measure")]
mod shift;
mod single_kernel;
mod spirv_module;
mod transfer;
mod vk_error;
#[cfg(feature = "window")]
pub mod window;

pub use adapter::{Adapter, Ids, Limits};
pub use allocator::MemoryUse;
pub(crate) use bind::Binding;
pub use choices::{AXES, Axis, Cache, Choices, Constants, Optimization, Submissions, Timed, Value};
pub use device::Device;
pub use driver_facts::{COUNTERS, STATISTICS, Statistic};
pub use execution::{EXECUTES, ExecutionCheck};
pub use instance::Instance;
#[cfg(feature = "measure")]
pub(crate) use interface::{disassembled, interface};
#[cfg(feature = "measure")]
pub(crate) use kernel::most_lanes;
pub use kernel::{Kernel, KernelKey, set_by_device};
pub use kernels::Kernels;
pub use list::{Place, Timing};
pub use logical_device::LogicalDevice;
pub use memory::Buffer;
pub use offers::Offers;
#[cfg(feature = "measure")]
pub(crate) use order::waits;
pub(crate) use record::{Recorder, Recordings, Work};
#[cfg(feature = "measure")]
pub(crate) use reflect::words_of;
pub use reflect::{
    Access, accesses, constants, group_is_open, kernel_names, kernels_without_subgroups, reflect_records, spirv,
};
pub use replace::{Given, kernels_of, replacements, source, sources};
#[cfg(feature = "measure")]
pub(crate) use shift::shifted;
pub use single_kernel::SingleKernel;
#[cfg(feature = "measure")]
pub(crate) use spirv_module::{Instruction, instructions};
#[cfg(feature = "measure")]
pub(crate) use spirv_module::{text, words_in};
pub(crate) use transfer::{BufferRange, Upload, download, upload};
