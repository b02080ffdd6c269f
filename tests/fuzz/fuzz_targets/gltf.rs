//! Fuzzes glTF files: as scenes by themselves, with their textures, and their animation `A`.
#![no_main]
mod shared;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    shared::mesh("a.gltf", bytes, &["", ", texture = 'mesh'"]);
    shared::alone("a.gltf", bytes, &["animation=A".to_string()]);
});
