//! The only home of `ash` and of `unsafe`: instance, device, memory, kernels, and the recording of a frame.
//!
//! Nothing here knows what a stage or a triangle is. Handles own what they need and free themselves.

mod alone;
mod bind;
#[cfg(feature = "shaderc")]
mod compile;
pub mod count;
mod device;
#[doc(hidden)]
pub mod faults;
mod instance;
mod kernel;
mod memory;
mod record;
mod reflect;
mod replace;
mod spirv_module;
mod transfer;

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
pub(crate) use transfer::{download, upload};
