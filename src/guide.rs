//! The user guide. Its pages are `src/guide/*.md`, which also read well in the repository.
//!
//! | page | answers |
//! |---|---|
//! | [Getting started](start) | installing, first pictures, devices, commands, exit codes |
//! | [Pictures of meshes](pictures) | a mesh alone in a studio; turntables, transparency, a lens; the gallery |
//! | [A window](window) | `view`: keys and drags, drafts, scripts |
//! | [Scenes](scenes) | scene files: objects, materials, textures, every key |
//! | [Meshes](meshes) | mesh files: formats, what is read and what not, animated characters |
//! | [Lights and looks](lights) | light types, shadows, environments, reflection, tone, layers of a picture |
//! | [Motion](motion) | deformation, keyframes, sequences, what is kept between frames |
//! | [Layers](layers) | subsurface texture mapping |
//! | [Shading by curvature](curvature) | the CDRF, where it is a good approximation, and its rivals |
//! | [How it works](how) | the frame, the model and where it is wrong, schemes, hierarchies, error estimate |
//! | [Diffusion](diffusion) | the diffusion equation on the object's own surface: nearer to the truth than the dipole |
//! | [Random walk](walk) | the reference without approximations: what it simulates, its noise, its time |
//! | [Measuring](measuring) | error norms, references, error against run time, extreme cases, the papers' tables |
//! | [Conformance](conformance) | for driver people: what is compared, and how to reduce a failure |
//! | [Sanitizing kernels](sanitizing) | data races, accesses out of bounds and more in kernels, by an interpreter |
//! | [For driver engineers](drivers) | failures as files that run elsewhere, results for build servers |
//! | [Performance](performance) | profiles, your own kernels, tuning |
//! | [Varying the API](api) | what a choice of Vulkan costs: descriptors, barriers, submissions, groups and more |
//! | [Why it is slow](bottlenecks) | what bounds each stage; the cost of dispatches, barriers, submissions, compiling |
//! | [Compilers of GPUs](compilers) | registers, spills and cycles of kernels on GPUs that are not here |
//! | [Experiments](experiments) | another oracle in one file of GLSL, another use of Vulkan: from file to figure |
//! | [Robustness](robustness) | limits, promises and the tests that verify them |
//! | [As a library](library) | the Rust API |
//! | [Contributing](contributing) | structure, rules, tests; recipes for a stage, a light, a format, a measurement |

/// Each name is a page. Links between pages lead to modules here, and to files in the repository: of two definitions
/// of a link the first one counts.
macro_rules! pages {
    ($($name:ident)*) => {
        pages!(@each [$($name)*] $($name)*);
    };
    (@each $all:tt $($name:ident)*) => { $(pages!(@one $all $name);)* };
    (@one [$($all:ident)*] $name:ident) => {
        #[doc = concat!($("[", stringify!($all), "]: crate::guide::", stringify!($all), "\n"),*)]
        #[doc = ""]
        #[doc = include_str!(concat!("guide/", stringify!($name), ".md"))]
        pub mod $name {}
    };
}

pages! {
    start pictures window scenes meshes lights motion layers curvature how diffusion walk measuring conformance sanitizing drivers performance bottlenecks compilers api experiments robustness library contributing
}
