//! From radiosity to a picture.

pub mod aov;
pub mod backdrop;
pub mod exit;
pub mod picture;
pub mod points;
pub mod reflect;
pub mod shade;
pub mod visibility;
