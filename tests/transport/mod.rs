//! Light transport inside a material: trees of faces and of space, links and blocks, and their error estimate.

mod blocks;
mod clusters;
mod coarse;
mod diffusion;
mod diffusion_auto;
mod diffusion_frames;
mod diffusion_scenes;
mod dropped;
mod estimate;
mod hierarchies;
mod octree;
mod projected;
mod subdivide;
mod walk;
mod walk_light;
mod walk_native;
mod walk_truth;
