//! Every call of Vulkan that can fail passes here: its result code becomes words, and a test can make any one of them fail.
//!
//! Nothing is injected unless a test asks for it on its own thread; then the call is not made at all, as if the driver had
//! answered at once.

use std::cell::RefCell;

use ash::vk;

use super::instance::Adapter;
use crate::error::{Error, Result};

/// A call that can fail.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// Its name in the specification.
    pub name: &'static str,
    /// What it was made for.
    pub doing: String,
}

/// What a thread's tests have asked for.
#[derive(Default)]
struct Asked {
    seen: Option<Vec<Call>>,
    failing: Option<usize>,
    alter: Option<fn(&mut Adapter)>,
}

thread_local! {
    static ASKED: RefCell<Asked> = RefCell::default();
}

/// Lists the calls that can fail and that `body` makes on this thread. With `failing`, the one of this number fails with the
/// result that is natural to it.
pub fn watch<T>(failing: Option<usize>, body: impl FnOnce() -> T) -> (T, Vec<Call>) {
    ASKED.with_borrow_mut(|asked| (asked.seen, asked.failing) = (Some(Vec::new()), failing));
    let done = body();
    let seen = ASKED.with_borrow_mut(|asked| (asked.failing, asked.seen.take()).1);
    (done, seen.unwrap_or_default())
}

/// Runs `body` while every adapter that this thread lists is altered: lower limits, another name.
pub fn on_altered<T>(alter: fn(&mut Adapter), body: impl FnOnce() -> T) -> T {
    ASKED.with_borrow_mut(|asked| asked.alter = Some(alter));
    let done = body();
    ASKED.with_borrow_mut(|asked| asked.alter = None);
    done
}

/// An adapter as a test wants it to be.
pub(super) fn altered(mut adapter: Adapter) -> Adapter {
    if let Some(alter) = ASKED.with_borrow(|asked| asked.alter) {
        alter(&mut adapter);
    }
    adapter
}

/// Makes a call that can fail.
pub(super) fn tried<T>(
    name: &'static str,
    doing: &str,
    call: impl FnOnce() -> std::result::Result<T, vk::Result>,
) -> Result<T> {
    let fails = ASKED.with_borrow_mut(|asked| {
        let seen = asked.seen.as_mut()?;
        seen.push(Call { name, doing: doing.to_string() });
        (asked.failing == Some(seen.len() - 1)).then(|| natural(name))
    });
    fails.map_or_else(call, Err).map_err(|code| Error::device(doing, words(name, code)))
}

/// The result that a call is most likely to fail with.
fn natural(name: &str) -> vk::Result {
    match name {
        "vkCreateInstance" => vk::Result::ERROR_INCOMPATIBLE_DRIVER,
        "vkCreateDevice" | "vkEnumeratePhysicalDevices" => vk::Result::ERROR_INITIALIZATION_FAILED,
        "vkQueueSubmit" | "vkGetQueryPoolResults" | "vkDeviceWaitIdle" => vk::Result::ERROR_DEVICE_LOST,
        "vkWaitForFences" => vk::Result::TIMEOUT,
        "vkAllocateDescriptorSets" => vk::Result::ERROR_OUT_OF_POOL_MEMORY,
        "vkMapMemory" => vk::Result::ERROR_MEMORY_MAP_FAILED,
        "vkAllocateMemory" | "vkBindBufferMemory" | "vkCreateQueryPool" => vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
        _ => vk::Result::ERROR_OUT_OF_HOST_MEMORY,
    }
}

/// A result code in words, and what to do about it.
fn words(name: &str, code: vk::Result) -> String {
    // Loaders answer that, too, where a driver's file is malformed.
    let no_driver = name == "vkCreateInstance" && code == vk::Result::ERROR_OUT_OF_HOST_MEMORY;
    let code = if no_driver { vk::Result::ERROR_INCOMPATIBLE_DRIVER } else { code };
    let (what, advice) = match code {
        vk::Result::ERROR_DEVICE_LOST => {
            ("the device was lost: its driver crashed, hung or was reset", "run it again, or with --device cpu")
        }
        vk::Result::TIMEOUT => (
            "the device has not finished in time: it hangs, or has more to do than MILKGLASS_TIMEOUT allows",
            "set that to more seconds, or use --device cpu",
        ),
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_POOL_MEMORY => {
            ("the device is out of memory", "use fewer triangles or pixels, --mode on-the-fly, or --device cpu")
        }
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => ("the host is out of memory", "use fewer triangles or pixels"),
        vk::Result::ERROR_MEMORY_MAP_FAILED => {
            ("the device's memory can't be seen by the host", "use another device, or --device cpu")
        }
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => (
            "no installed driver supports Vulkan 1.2",
            "install one (Debian: mesa-vulkan-drivers), look at VK_DRIVER_FILES, or use --device cpu",
        ),
        vk::Result::ERROR_INITIALIZATION_FAILED => {
            ("the driver failed to start", "update it, use another device, or --device cpu")
        }
        vk::Result::ERROR_LAYER_NOT_PRESENT => (
            "the validation layer is not installed",
            "install it (Debian: vulkan-validationlayers), or unset MILKGLASS_VALIDATION; `conform` takes --no-validation",
        ),
        vk::Result::ERROR_EXTENSION_NOT_PRESENT => {
            ("the driver lacks an extension that was asked for", "unset MILKGLASS_VALIDATION, or update the driver")
        }
        vk::Result::ERROR_FEATURE_NOT_PRESENT => {
            ("the driver lacks a feature that was asked for", "update it, or use --device cpu")
        }
        other => return format!("the driver answered {other:?} ({name}); use another device, or --device cpu"),
    };
    format!("{what} ({name}); {advice}")
}
