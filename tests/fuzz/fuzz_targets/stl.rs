//! Fuzzes STL files.
#![no_main]
mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shared::mesh("a.stl", bytes, &[""]));
