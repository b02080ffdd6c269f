//! A kernel that writes beyond the end of its part of a buffer is reported, though drivers drop such writes.

use crate::devices::on_devices;
use crate::shell::folder;
use milkglass::internals::gpu::{Given, replacements, source};
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::replace::check;
use milkglass::scene::Scene;

const KERNEL: &str = "lighting/opaque_faces";

/// Opaque objects lit by triangle: one in the middle of the scene's parts of buffers, one at their end.
fn opaque() -> [Fixture; 2] {
    let slab = "{ shape = 'slab', detail = 3, size = 50, position = [1, -12, 0], material = { opaque = true } }";
    let ball = "{ shape = 'sphere', detail = 1, size = 9, position = [16, -4, 3], material = { preset = 'marble' } }";
    [[slab, ball], [ball, slab]].map(|[second, third]| {
        let sets = [
            "object.0.detail=1".to_string(),
            format!("object.1={second}"),
            format!("object.2={third}"),
            "transport.receivers=faces".to_string(),
            "camera.size=[8, 8]".to_string(),
        ];
        Fixture::of_scene("opaque", &Scene::load_with("sphere", &sets).unwrap()).unwrap()
    })
}

/// The faults that are found in the kernel with `part` replaced by `other`.
fn faults(part: &str, other: &str) -> Vec<String> {
    let text = source(KERNEL).unwrap();
    assert!(text.contains(part));
    let here = folder(&[]);
    let file = here.path().join("mine.comp");
    std::fs::write(&file, text.replace(part, other)).unwrap();
    let list = opaque();
    let found = std::sync::Mutex::new(Vec::new());
    on_devices(|device| {
        let device =
            device.replacing(KERNEL, replacements(KERNEL, &file, &Given::default()).unwrap().remove(0).1).unwrap();
        let rows = check(&device, &list).unwrap();
        assert!(rows.iter().all(|row| row.distances.words > 0) && !rows.is_empty());
        found.lock().unwrap().extend(rows.into_iter().flat_map(|row| row.faults));
    });
    found.into_inner().unwrap()
}

#[test]
fn writes_beyond_the_end_are_reported() {
    let more = "if (face == 0) radiosity[object_params[0].faces] = vec3(7);\n    if (face";
    let found = faults("if (face", more);
    // Writes for the middle object land between the objects' parts, those for the last one after the buffer's end.
    let has = |what: [&str; 2]| found.iter().any(|fault| what.iter().all(|part| fault.contains(part)));
    assert!(has(["opaque_faces of object 1", "beyond tolerance, 3 words: radiosity["]), "{found:?}");
    assert!(has(["opaque_faces of object 2", "wrote beyond the end of buffer radiosity"]), "{found:?}");
}

#[test]
fn what_is_bound_beyond_the_end_does_not_count_as_length() {
    assert_eq!(faults("face < object_params[0].faces", "face < radiosity.length()"), [""; 0]);
}
