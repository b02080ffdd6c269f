//! From radiosity to a picture.

pub mod aov;
pub mod backdrop;
pub mod exit;
pub mod picture;
pub mod plain;
pub mod points;
pub mod reached;
pub mod reflect;
pub mod shade;
pub mod visibility;
pub mod whole;
