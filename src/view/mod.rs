//! From radiosity to a picture.

pub mod aov;
pub mod picture;
pub mod shade;
pub mod visibility;
