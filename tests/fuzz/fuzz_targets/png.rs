//! Fuzzes PNG files as environment, texture and map of layers.
#![no_main]
mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shared::image("a.png", bytes));
