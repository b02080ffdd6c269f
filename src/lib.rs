//! milkglass
pub mod command;
pub mod error;
pub mod geometry;
pub mod gpu;
pub mod hierarchy;
pub mod layout;
pub mod light;
pub mod measure;
pub mod render;
pub mod scene;
pub mod state;
pub mod transport;
pub mod view;
