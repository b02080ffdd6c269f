//! The one way to make a call of Vulkan that can fail: tests inject faults here, and result codes become errors.

use ash::vk;

use super::faults::inject;
use super::vk_error::vk_error;
use crate::error::Result;

/// Makes a call that can fail. `name` is its name in the specification, `doing` what it is made for.
pub(super) fn vk_call<T>(
    name: &'static str,
    doing: &str,
    call: impl FnOnce() -> std::result::Result<T, vk::Result>,
) -> Result<T> {
    inject(name, doing).map_or_else(call, Err).map_err(|code| vk_error(name, doing, code))
}
