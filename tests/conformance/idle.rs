//! Devices that report work as done and do none: null hardware, and dispatches that are lost.

use crate::devices::layer;
use crate::shell::{folder, program, said};
use milkglass::error::Error;
use milkglass::internals::gpu::faults::on_idle;
use milkglass::internals::gpu::{Choices, Device, EXECUTES, Instance, Submissions};
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// A device that reports work as done and does none is refused, when it is opened and after any frame.
#[test]
fn a_device_that_executes_nothing_is_refused() {
    let _layer = layer();
    let instance = Instance::open(true).unwrap();
    let scene = Scene::load_with("sphere", &["object.0.detail=2".to_string()]).unwrap();
    let adapters = instance.adapters().unwrap();
    for adapter in adapters.iter().filter(|adapter| adapter.unusable.is_none()) {
        let refused = |error: Error| {
            assert_eq!(error.exit_code(), 3);
            assert!(error.to_string().contains("did not execute"), "{error}");
        };
        refused(on_idle(|_| true, || Device::open(&instance, adapter)).err().unwrap());
        // From the second frame on, every dispatch is lost, or only the last one.
        for lost in [(|_| true) as fn(&str) -> bool, |kernel| kernel == EXECUTES] {
            // Frames are recorded anew: dispatches are lost while they are recorded.
            let anew = Choices { submissions: Submissions::Frame, ..Choices::default() };
            let device = Device::open_as(&instance, adapter, &anew).unwrap();
            let mut session = Session::new(&scene, Some(&device), Options::default()).unwrap();
            session.frame(Change::EVERYTHING).unwrap();
            refused(on_idle(lost, || session.frame(Change::EVERYTHING)).unwrap_err());
            // Nothing is submitted to it any more, nor destroyed.
            let later = session.frame(Change::EVERYTHING).unwrap_err().to_string();
            assert!(later.contains("does not execute"), "{later}");
            drop(session);
            assert!(!device.allocations().is_empty());
        }
    }
    let here = tempfile::tempdir().unwrap();
    let picture = here.path().join("idle.png");
    let words = ["milkglass", "render", "sphere", "--set", "camera.size=[8,8]", "-o", picture.to_str().unwrap()];
    let done = on_idle(|_| true, || milkglass::cli::run(words.map(Into::into)));
    assert_eq!(done.unwrap_err().exit_code(), 3);
    assert!(!picture.exists());
    assert!(instance.take_messages().is_empty());
}

/// RADV's null device runs nothing, and crashes when it is destroyed.
#[test]
fn null_hardware_is_unusable() {
    let here = folder(&[]);
    let places = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let files = places.iter().filter_map(|place| std::fs::read_dir(place).ok()).flatten();
    let radeon =
        |path: &std::path::Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("radeon"));
    let Some(driver) = files.map(|file| file.unwrap().path()).find(|path| radeon(path)) else {
        println!("null hardware: not tested (RADV is not installed)");
        return;
    };
    let run = |line: &str| {
        let mut command = program(&here, line);
        command.env("RADV_FORCE_FAMILY", "navi21").env("VK_DRIVER_FILES", &driver).env("VK_ICD_FILENAMES", &driver);
        let output = command.output().unwrap();
        let (out, err) = said(&output);
        (output.status.code(), out, err)
    };
    let (code, out, _) = run("devices");
    assert!(code == Some(0) && out.contains("Null hardware") && out.contains("executes none"), "{out}");
    for line in
        ["render sphere --device 0 -o x.png", "conform", "profile sphere --device navi21", "plan sphere --device 0"]
    {
        let (code, out, err) = run(line);
        assert_eq!(code, Some(3), "{line}\n{out}{err}");
    }
    // Without a device by name, the CPU renders.
    let (code, _, err) = run("render sphere --set object.0.detail=1 --set camera.size=[8,8] -o cpu.png");
    assert!(code == Some(0) && err.contains("running on the CPU") && err.contains("null hardware"), "{err}");
}
