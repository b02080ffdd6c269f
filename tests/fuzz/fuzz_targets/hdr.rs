//! A file as an image wherever a scene takes one of its kind.
#![no_main]
mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shared::image("a.hdr", bytes));
