//! Every usable device in turn, with validation, for the tests that need one.

use std::sync::Mutex;

use milkglass::gpu::{Adapter, Device, Instance};

/// One device at a time: messages belong to the instance that opened it.
static TURN: Mutex<()> = Mutex::new(());

/// Runs `body` on every usable device, with validation; fails where there is none, unless `MILKGLASS_NO_DEVICE` is set.
pub fn on_devices(body: impl Fn(&Device)) {
    let _turn = TURN.lock().unwrap_or_else(|broken| broken.into_inner());
    let instance = match Instance::open(true) {
        Ok(instance) => instance,
        Err(error) if std::env::var_os("MILKGLASS_NO_DEVICE").is_some() => {
            println!("WAIVED by MILKGLASS_NO_DEVICE: {error}");
            return;
        }
        Err(error) => panic!("{error}"),
    };
    let usable: Vec<Adapter> = instance.adapters().unwrap().into_iter().filter(|a| a.unusable.is_none()).collect();
    if usable.is_empty() && std::env::var_os("MILKGLASS_NO_DEVICE").is_some() {
        println!("WAIVED by MILKGLASS_NO_DEVICE: no usable device");
        return;
    }
    assert!(!usable.is_empty(), "no usable Vulkan device");
    for adapter in usable {
        let device = Device::open(&instance, &adapter).unwrap();
        body(&device);
        let messages = device.take_messages();
        assert!(messages.is_empty(), "{}: {}", adapter.name, messages.join("\n"));
    }
}
