//! Opens every usable device in turn, with validation, for the tests that need one. A scene's buffers hold 0xff bytes
//! at first, NaN as floats: what reads memory before anything has written it fails, instead of once in some runs.

use std::sync::atomic::{AtomicUsize, Ordering};

use milkglass::internals::gpu::{Adapter, Choices, Device, Instance};

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
    let adapter = usable.get(number)?;
    let choices = Choices { fill: Some(0xff), ..Choices::default() };
    Some(Device::open(&instance, adapter).unwrap().opened_as(&choices).unwrap())
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
