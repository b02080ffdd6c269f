//! Fuzzes a scene file, with a mesh and a texture that it may name.
#![no_main]
mod shared;

const MESH: &[u8] = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nf 1/1 3/1 2/1\nf 1/1 2/1 4/1\nf 1/1 4/1 3/1\nf 2/1 3/1 4/1\n";
const LIBRARY: &[u8] = b"newmtl a\nmap_Kd m.png\n";

libfuzzer_sys::fuzz_target!(|text: &str| {
    let png = include_bytes!("../seeds/png/grey.png");
    shared::load(text, &[("m.obj", MESH), ("m.mtl", LIBRARY), ("m.png", png), ("n.obj", MESH)]);
});
