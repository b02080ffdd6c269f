//! How milkglass is built: the modules behind the front door, for its own command line, tests and benches. They may
//! change with any release.
//!
//! # A frame
//!
//! [`pipeline::frame::FRAME`] lists the whole frame on one page: every stage in order, under headings, with the loops
//! that it runs in. In short:
//!
//! 1. Shape: `skin` places vertices by joints, `deform` moves them; `refit` fits triangles, clusters and vertex normals
//!    to them. All this, and transport, is in each object's own frame; `placement` turns and shifts objects into the
//!    scene, where rays and lights are. `widen` lays out the tree for rays; `visibility` finds what each pixel sees.
//! 2. Light that enters each face (equation 5): `shadow`, `environment`, `irradiance`, `texture_in`.
//! 3. Transport to blocks of receivers: `pull` sums moments of that light up the tree of clusters; `coarse_solve`
//!    estimates the object's brightness; `acceptance_radii` turns the tolerance into a distance per cluster; `link`
//!    lists the emitters of each block; `gather` sums over the lists; `push` hands the sums to the receivers. Transport
//!    by links, as published, by brute force, by an octree or by a random walk replaces these stages. Diffusion keeps
//!    `pull`, `acceptance_radii` and `link`, whose lists its own stages sum over.
//! 4. Light that leaves (equation 3): `shade`; `pixel_shadow`, for opaque objects and reflections, and `shade_opaque`;
//!    `texture_out`; `relief` adds single scattering in layers (Francois et al. 2006); `reflect` adds reflections,
//!    `backdrop` the environment.
//!
//! With `--transport cdrf`, `lambert` or `texture-blur` there is no transport: stages of [`shading`] replace step 3.
//!
//! A stage is one file: its equation, its `f64` reference, its dispatches, its tolerance, and everything that a plan
//! needs to know about it ([`state::Stage`]), as far as its module does not declare it for all of its stages. Adding a
//! stage takes that file, its shader, a `mod` line and a line in the frame; an incomplete declaration does not compile.
//!
//! Equations and sections are those of Mertens et al. 2003, "Interactive Rendering of Translucent Deformable Objects".
//!
//! # Modules, from the top layer down; each depends on lower ones only
//!
//! - `cli`, by the feature of that name: one thin file per subcommand, on the public API.
//! - [`crate::measure`]: conformance, an interpreter of kernels, profiles, users' own shaders, error norms, the
//!   brute-force reference, error against run time, extreme cases, the tables of the papers beside ours, numerical
//!   error beside the model's, and a report of it all.
//! - [`session`]: runs frames on the CPU or a device, and reads their results.
//! - [`prepare`]: builds the state from a scene.
//! - [`pipeline`]: the frame, the plan (the stages that a state needs, and why the others are skipped), buffer sizes.
//! - [`transport`]: Mertens et al.: [`transport::blocks`], to a given tolerance; [`transport::links`], as published;
//!   brute force; an octree; [`transport::walk`], without a model. [`layers`]: Francois et al., subsurface texture
//!   mapping. [`shading`]: shading by curvature, Kubo et al., and its rivals. [`view`]: from radiosity to a picture.
//! - [`dipole`]: the diffusion profile, its derivatives, form factors.
//! - [`lighting`]: light that arrives, and Fresnel's formulas.
//! - [`geometry`]: from positions to clusters; rays through the same trees.
//! - [`state`]: the data of a frame, the definition of a stage, and the state's copy on a device.
//! - [`crate::scene`]: the user's scene, checked. [`hierarchy`]: from a mesh to a tree. [`gpu`]: the only user of
//!   `ash`.
//! - [`layout`]: the one source of truth for records, buffers and constants, shared with the build script and the
//!   shaders.
//! - [`crate::error`]: the error type; its variants say whose fault it is. [`phases`]: wall time beside stages.
//!
//! `glsl/` has the same modules and file names: `glsl/transport/blocks/push.comp` is `src/transport/blocks/push.rs`.
//! `glsl/measure` measures devices and belongs to no stage.
//!
//! # Words
//!
//! - *stage*: a step of the frame, with a CPU reference and GPU kernels of the same name; *kernel*: one shader;
//!   *step*: a stage, run for one object, chunk, group or batch (its *scope*).
//! - *buffer id*: the name of a buffer; its number is its binding. *Record*: a struct shared by host and device.
//! - *cluster*, *node*: a subtree of faces; a leaf is one triangle. *Link*: a transfer of light from one node to
//!   another.
//! - *irradiance* E: light that enters, after Fresnel; *radiosity* B: light that leaves, before Fresnel.
//! - *quadrature rule* of a form factor: one sample, 3, 6 or 12 area points, or the edge form.
//! - *block*: up to 16 receivers that share lists: a subtree's faces, or neighbouring points that a tile of pixels
//!   shows. *Batch*: blocks linked together. *Chunk*: the subtree that scheme `links` links at once. *Group*: colour
//!   channels whose irradiances are proportional, transported together.
//! - *moments*: sum W, centroid and second moments Q of a cluster's light; *expansion*: a quadratic about a block's
//!   centre.
//! - *hand down*: leave an emitter to the receiver's children. A link is *stale* until its form factor is recomputed.
//! - *interface*: the lower end of a layer, given by its depth; *leg*: the light's path from entry to scattering.
//! - *island*: triangles that are connected in texture space; *seam*: an edge where two islands meet; *margin*: texels
//!   around an island that repeat what lies across its seams.
//! - *kappa*: the curvature that matters for scattering; *sigma_0*: how far light spreads along a surface; *CDRF*:
//!   curvature-dependent reflectance function, of the cosine and sigma = sigma_0 kappa.
//! - *lanes*: the invocations that share an item (a block, a sample, a ray): 1 on a processor, more on a GPU.
//! - *tally*: a kernel's counts of its own work; *rate*: the most that a device does per second.
//! - *internal units*: the scene has unit extent, the brightest light about unit irradiance; both scales are powers of
//!   two.

#[path = "dipole/mod.rs"]
pub mod dipole;
#[path = "geometry/mod.rs"]
pub mod geometry;
#[path = "gpu/mod.rs"]
pub mod gpu;
#[path = "hierarchy/mod.rs"]
pub mod hierarchy;
#[path = "layers/mod.rs"]
pub mod layers;
#[path = "layout/mod.rs"]
pub mod layout;
#[path = "lighting/mod.rs"]
pub mod lighting;
#[path = "phases.rs"]
pub mod phases;
#[path = "pipeline/mod.rs"]
pub mod pipeline;
#[path = "prepare/mod.rs"]
pub mod prepare;
#[path = "session/mod.rs"]
pub mod session;
#[path = "shading/mod.rs"]
pub mod shading;
#[path = "state/mod.rs"]
pub mod state;
#[path = "transport/mod.rs"]
pub mod transport;
#[path = "view/mod.rs"]
pub mod view;
