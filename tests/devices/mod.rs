//! Opens every usable device in turn, with validation, for the tests that need one. A scene's buffers hold 0xff bytes
//! at first, NaN as floats: what reads memory before anything has written it fails, instead of once in some runs.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Barrier, Mutex, MutexGuard, PoisonError};

use milkglass::internals::gpu::{Adapter, Choices, Device, Instance};

/// Held by the test that uses the validation layer.
static LAYER: Mutex<()> = Mutex::new(());

/// Waits until no other test of this process uses the validation layer. The layer finds a call's device in a table
/// without a lock, so that it may crash while another thread opens or closes a device (version 1.3.239;
/// KhronosGroup/Vulkan-ValidationLayers, issue 4391).
pub fn layer() -> MutexGuard<'static, ()> {
    LAYER.lock().unwrap_or_else(PoisonError::into_inner)
}

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
    Some(Device::open_as(&instance, adapter, &choices).unwrap())
}

/// Runs `body`; fails on any validation message.
fn silent<R>(device: &Device, body: impl FnOnce(&Device) -> R) -> R {
    let done = body(device);
    let messages = device.take_messages();
    assert!(messages.is_empty(), "{}: {}", device.name(), messages.join("\n"));
    done
}

/// Runs `body` on every usable device.
pub fn on_devices(body: impl Fn(&Device)) {
    let _layer = layer();
    for device in (0..).map_while(opened) {
        silent(&device, &body);
    }
}

/// Runs `body` for each item on every usable device, in two threads with a device each: half of the work keeps only one
/// core busy. It opens no other device: see [`layer`].
pub fn on_devices_each<T: Sync>(items: &[T], body: impl Fn(&Device, &T) + Sync) {
    let _layer = layer();
    let count = (0..).map_while(opened).count();
    for number in 0..count {
        let next = AtomicUsize::new(0);
        // Both devices are open before either is used, and used no more when either is closed.
        let (door, together) = (Mutex::new(()), Barrier::new(2));
        let some = || {
            let device = {
                let _one = door.lock();
                opened(number)
            };
            together.wait();
            let done = catch_unwind(AssertUnwindSafe(|| {
                silent(device.as_ref().unwrap(), |device| {
                    while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                        body(device, item);
                    }
                });
            }));
            together.wait();
            let _one = door.lock();
            drop(device);
            done.unwrap_or_else(|why| resume_unwind(why));
        };
        std::thread::scope(|scope| {
            scope.spawn(some);
            some();
        });
    }
}
