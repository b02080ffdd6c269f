//! Fuzzes PNG files in every place where a scene takes an image.
#![no_main]
mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shared::image("a.png", bytes));
