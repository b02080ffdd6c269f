//! From radiosity to a picture, and files on disk.

pub mod accumulate;
pub mod aov;
pub mod atomic_file;
pub mod backdrop;
pub mod picture;
pub mod pixel_receivers;
pub mod pixel_shadow;
pub mod reflect;
pub mod shade;
pub mod shade_opaque;
pub mod texture_out;
pub mod tone;
pub mod visibility;
