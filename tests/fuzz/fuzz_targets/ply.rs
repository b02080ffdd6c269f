//! Fuzzes PLY files, with and without their colours as a texture.
#![no_main]
mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shared::mesh("a.ply", bytes, &["", ", texture = 'mesh'"]));
