//! Methods and pictures: against closed forms, published figures and one another, on the CPU and on every device.

mod devices;
mod native_walk;
mod population;
mod shell;

mod analytic;
mod frames;
mod layers;
mod lights;
mod shading;
mod transport;
