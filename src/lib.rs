//! milkglass renders translucent materials (marble, milk, wax, skin, leaves) with hand-written Vulkan compute
//! pipelines, each tested against a CPU reference.
//!
//! ```no_run
//! use milkglass::{Device, Error, Options, Scene, Session};
//!
//! fn main() -> Result<(), Error> {
//!     let scene = Scene::load("lotus")?; // a built-in scene, a scene file or a mesh
//!     let device = Device::best()?; // none: the CPU reference renders
//!     let mut session = Session::new(&scene, device.as_ref(), Options::default())?;
//!     session.render()?.save("lotus.png")
//! }
//! ```
//!
//! - [`Scene`]: objects, their materials, lights and a camera, loaded and checked; its parts are in [`scene`].
//! - [`Device`]: a Vulkan device. Everything also runs without one, on the CPU, in `f64` and slower.
//! - [`Session`]: renders a scene frame after frame, with another light, shape or camera each time; also the light of
//!   every face ([`FaceLight`]).
//! - [`Options`]: how light is carried through the material, and what is kept from frame to frame.
//! - [`Picture`]: linear radiance, saved as PNG or OpenEXR.
//! - [`Error`]: what went wrong, and whose fault it is.
//! - [`measure`]: conformance of a device, profiles, error against run time (feature `measure`).
//!
//! Begin with [`guide::start`]; the [`guide`] explains scenes, methods and measurements, and [`internals`] the code.
//!
//! # Features
//!
//! | feature | default | brings |
//! |---|---|---|
//! | `cli` | yes | the program `milkglass`; a library does without: `default-features = false` |
//! | `measure` | with `cli` | the module [`measure`] |
//! | `shaderc` | yes | kernels of your own in place of built-in ones, compiled at run time |
//! | `window` | no | the command `view`, a window that shows a scene; needs Rust 1.95 |
//! | `build-from-source` | no | builds shaderc from source, where neither `glslc` nor shaderc is installed |
//!
//! A published package contains its kernels as SPIR-V. In a checkout the build compiles them with `glslc`.

#![deny(missing_docs)]

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod error;
#[cfg(doc)]
pub mod guide;
pub mod internals;
#[cfg(feature = "measure")]
pub mod measure;
pub mod scene;

use internals::*;

// The command line is written against the public API, by its name.
#[cfg(feature = "cli")]
extern crate self as milkglass;

#[doc(inline)]
pub use error::{Error, Result};
#[doc(inline)]
pub use gpu::Device;
#[doc(inline)]
pub use scene::Scene;
#[doc(inline)]
pub use session::faces::FaceLight;
#[doc(inline)]
pub use session::run::Session;
#[doc(inline)]
pub use state::options::{Goal, Mode, Options, ShadingMethod};
#[doc(inline)]
pub use view::picture::Picture;
