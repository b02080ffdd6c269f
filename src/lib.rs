//! milkglass renders translucent things with hand-written Vulkan compute pipelines, and proves every one of them
//! against a CPU reference.
//!
//! # A frame
//!
//! 1. `deform`: the shape of this frame; `refit`: positions to faces, clusters and vertex normals; `visibility`: what each pixel sees;
//! 2. `shadow`: which lights reach which faces; `environment`: harmonics of the light from all around; `irradiance`: the
//!    light that enters each face (equation 5); `texture_in`: times a texture;
//! 3. `pull`: moments of the light that enters every cluster;
//! 4. `coarse_solve`: how bright the object will be, roughly; `irradiance_ratio`: against the light, where lists serve any;
//! 5. `acceptance_radii`: how far from a cluster what may be done with it, so that the tolerance is met;
//! 6. `pixel_receivers`: the places that pixels show, where those receive; `link`: which emitters each block of receivers expands, links, or takes triangle by triangle;
//! 7. `gather`: what they give the block;
//! 8. `push`: from blocks to receivers; `opaque_faces`: what opaque objects give back, by triangle; `average`: to vertices;
//! 9. `shade`: with which radiance each pixel shines (equation 3); `pixel_shadow` and `shade_opaque`: opaque objects, lit where the pixels
//!    show them; `texture_out`: times a texture; `plane_fit` and `relief`: plus
//!    what scatters once in layers beneath the surface (Francois et al. 2006); `reflect`:
//!    what the surface itself reflects, and `backdrop`: the environment behind the object.
//!
//! With `--transport cdrf` or `lambert` steps 3 to 8 have no place: `pack_normals` follows `refit`, after `curvature` where that counts, and `cdrf`, perhaps by
//! `cdrf_table` and `cdrf_cells`, or `lambert` takes the place of `shade`. With `texture-blur` those are `bake_irradiance`, `blur` and `texture_blur`.
//!
//! Equations and sections are those of Mertens et al. 2003, "Interactive Rendering of Translucent Deformable Objects".
//!
//! # The modules, from the top floor down; arrows point downward only
//!
//! - `cli`, in the binary: one thin file a subcommand.
//! - [`measure`]: conformance, profiles, shaders of the user's, error norms, the brute-force reference, error against run
//!   time, the extreme cases, the tables of the papers beside ours, numerical error beside the model's, and a report of it all.
//! - [`session`]: frame after frame on the CPU or a device, and what is read out of one. [`prepare`]: from a scene to a state.
//!   [`pipeline`]: the stages that a state needs, and the table of stages.
//! - [`transport`]: Mertens et al.: [`transport::blocks`], made to meet an error; [`transport::links`], as published; brute
//!   force; an octree.
//!   [`layers`]: Francois et al., subsurface texture mapping. [`shading`]: shading by the place alone, Kubo et al., or by what is
//!   near it in the texture, d'Eon et al.
//!   [`view`]: from radiosity to a picture.
//! - [`dipole`]: the profile, its derivatives, form factors: the mathematics of both.
//! - [`lighting`]: light arriving, and Fresnel's formulas.
//! - [`geometry`]: from positions to clusters; rays through the same trees.
//! - [`state`]: what a frame works on, what a stage is, and the state's twin on a device.
//! - [`scene`]: what the user wrote, checked. [`hierarchy`]: from a mesh to a tree. [`gpu`]: the only home of `ash`.
//! - [`layout`]: the one source of truth for records and buffers, shared with the build script and the shaders.
//! - [`error`]: one error, by whose fault it is.
//!
//! `glsl/measure` measures devices and belongs to no stage; else `glsl/` has the same modules and the same stems: `glsl/transport/blocks/push.comp` is `src/transport/blocks/push.rs`.
//!
//! # Words
//!
//! - *stage*: a step of the frame, with a CPU reference and GPU kernels of the same name; *kernel*: one shader;
//!   *step*: a stage, run for one chunk, group or batch.
//! - *buffer id*: the name of a buffer; its number is its binding. *Record*: a struct shared by host and device.
//! - *cluster*, *node*: a subtree of faces; a leaf is one triangle. *Link*: a node that receives from another.
//! - *irradiance* E: light that enters, after Fresnel; *radiosity* B: light that leaves, before Fresnel.
//! - *rule*: how a form factor is evaluated: one sample, 3, 6 or 12 area points, or the edge form.
//! - *block*: a maximal node of at most 16 faces, or nearby places that a tile of pixels shows: receivers that share their
//!   lists; *batch*: blocks linked in one go;
//!   *group*: channels whose irradiances are proportional, carried together.
//! - *moments*: sum W, centroid and second moments Q of a cluster's light; *expansion*: a quadratic about a block's centre.
//! - *interface*: the lower end of a layer, given by its depth; *leg*: light's way from where it enters to where it scatters.
//! - *island*: triangles whose texture coordinates go on from one to the next; *seam*: an edge where they do not; *margin*: texels
//!   round an island that have what lies across its seams.
//! - *altered*: with a triangle that has moved since kept links were made; *relit*: with one that another light enters than was
//!   summed last; a link is *stale* while its form factor waits; a receiver is *busy* if its links are merged or summed again.
//! - *chunk*: the receivers linked in one go; *capacity*: how much fits a list; *hand down*: leave an emitter to the
//!   receiver's children.
//! - *base*: a coarse mesh whose triangles are cut in four, *split*, again and again: butterfly subdivision and shrink-wrapping.
//! - *kappa*: the curvature that counts for scattering; *sigma_0*: how far light spreads along a surface; *CDRF*: the
//!   function of the cosine at the surface and sigma = sigma_0 kappa.
//! - *tally*: what a kernel has done, counted by itself; *rate*: what a device can do at best.
//! - *irradiance map*: light over all texels of a mesh's texture coordinates, as it enters or blurred by a Gaussian; *texel hit*: what a
//!   texel shows; *stretch*: the lengths that it spans.
//! - *internal units*: the object has unit extent, the brightest light about unit irradiance; both by powers of two.

#![deny(missing_docs)]

pub mod dipole;
pub mod error;
pub mod geometry;
pub mod gpu;
pub mod hierarchy;
pub mod layers;
pub mod layout;
pub mod lighting;
pub mod measure;
pub mod pipeline;
pub mod prepare;
pub mod scene;
pub mod session;
pub mod shading;
pub mod state;
pub mod transport;
pub mod view;
