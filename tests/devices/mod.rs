//! Opens every usable device in turn, with validation, for the tests that need one.

use std::sync::atomic::{AtomicUsize, Ordering};

use milkglass::internals::gpu::{Adapter, Device, Instance};

/// The usable device of this number, with validation. Fails if there is no usable device at all, unless
/// `MILKGLASS_NO_DEVICE` is set.
fn opened(number: usize) -> Option<Device> {
    let waived = std::env::var_os("MILKGLASS_NO_DEVICE").is_some();
    let instance = match Instance::open(true) {
        Ok(instance) => instance,
        Err(error) if waived => {
            println!("WAIVED by MILKGLASS_NO_DEVICE: {error}");
            return None;
        }
        Err(error) => panic!("{error}"),
    };
    let usable: Vec<Adapter> = instance.adapters().unwrap().into_iter().filter(|a| a.unusable.is_none()).collect();
    assert!(!usable.is_empty() || waived, "no usable Vulkan device");
    if usable.is_empty() {
        println!("WAIVED by MILKGLASS_NO_DEVICE: no usable device");
    }
    usable.get(number).map(|adapter| Device::open(&instance, adapter).unwrap())
}

/// Runs `body`; fails on any validation message.
fn silent<R>(device: &Device, body: impl FnOnce(&Device) -> R) -> R {
    let done = body(device);
    let messages = device.take_messages();
    assert!(messages.is_empty(), "{}: {}", device.name(), messages.join("\n"));
    done
}

/// Runs `body` on every usable device.
#[allow(dead_code, reason = "each test program uses one of the two")]
pub fn on_devices(body: impl Fn(&Device)) {
    for device in (0..).map_while(opened) {
        silent(&device, &body);
    }
}

/// Runs `body` for each item on every usable device, in two threads with a device each: half of the work keeps only one
/// core busy.
#[allow(dead_code, reason = "each test program uses one of the two")]
pub fn on_devices_each<T: Sync>(items: &[T], body: impl Fn(&Device, &T) + Sync) {
    let count = (0..).map_while(opened).count();
    for number in 0..count {
        let next = AtomicUsize::new(0);
        let some = || {
            silent(&opened(number).unwrap(), |device| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                    body(device, item);
                }
            });
        };
        std::thread::scope(|scope| {
            scope.spawn(some);
            some();
        });
    }
}
