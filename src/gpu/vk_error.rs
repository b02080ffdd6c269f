//! The result codes of Vulkan as errors of the program: what happened, and what to do about it.

use ash::vk;

use crate::error::Error;

/// The error for a call that failed with this code, `doing` something.
pub(super) fn vk_error(call: &str, doing: &str, code: vk::Result) -> Error {
    Error::device(doing, words(call, code))
}

/// A result code in words, and what to do about it. `call` is the name of the call in the specification.
fn words(call: &str, code: vk::Result) -> String {
    // Loaders return that code also where a driver's file is malformed.
    let no_driver = call == "vkCreateInstance" && code == vk::Result::ERROR_OUT_OF_HOST_MEMORY;
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
        other => return format!("the driver answered {other:?} ({call}); use another device, or --device cpu"),
    };
    format!("{what} ({call}); {advice}")
}
