//! Fault injection for tests: any call of Vulkan that can fail can be made to fail, adapters can be made to promise
//! less than they do, and dispatches can be left out. What tools are told can be listened to.
//!
//! Nothing is injected unless a test requests it on its own thread. A call that is to fail is not made at all, as if
//! the driver had returned at once.

use std::cell::RefCell;

use ash::vk;

use super::adapter::Adapter;

/// A call that can fail.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// Its name in the specification.
    pub name: &'static str,
    /// What it was made for.
    pub doing: String,
}

/// What tools such as RenderDoc are told, and the dispatches that it is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// An object of a type, `FENCE`, has a name.
    Name(String, String),
    /// What is recorded next is within this label.
    Begin(String),
    /// A dispatch of this kernel is recorded.
    Dispatch(String),
    /// The latest label ends.
    End,
    /// A command buffer of a frame ends.
    Close,
}

/// What the test on this thread requests.
#[derive(Default)]
struct Request {
    /// The calls made so far, where they are watched.
    seen: Option<Vec<Call>>,
    /// The index of the call that is to fail.
    failing: Option<usize>,
    /// What tools have been told so far, where that is listened to.
    told: Option<Vec<Told>>,
    alter: Option<fn(&mut Adapter)>,
    /// Which kernels' dispatches are left out.
    dropped: Option<fn(&str) -> bool>,
}

thread_local! {
    static REQUEST: RefCell<Request> = RefCell::default();
}

/// Runs `body`, and lists the calls that can fail and that it makes on this thread. With `failing`, the call of this
/// index fails with the result code that is most likely for it.
pub fn watch<T>(failing: Option<usize>, body: impl FnOnce() -> T) -> (T, Vec<Call>) {
    REQUEST.with_borrow_mut(|request| (request.seen, request.failing) = (Some(Vec::new()), failing));
    let done = body();
    let seen = REQUEST.with_borrow_mut(|request| request.seen.take());
    (done, seen.unwrap_or_default())
}

/// Runs `body` while dispatches of kernels for which `dropped` holds are recorded on this thread as if they were none:
/// the device reports them as done, and does nothing.
pub fn on_idle<T>(dropped: fn(&str) -> bool, body: impl FnOnce() -> T) -> T {
    REQUEST.with_borrow_mut(|request| request.dropped = Some(dropped));
    let done = body();
    REQUEST.with_borrow_mut(|request| request.dropped = None);
    done
}

/// Runs `body`, and lists what it tells tools on this thread.
pub fn listen<T>(body: impl FnOnce() -> T) -> (T, Vec<Told>) {
    REQUEST.with_borrow_mut(|request| request.told = Some(Vec::new()));
    let done = body();
    let told = REQUEST.with_borrow_mut(|request| request.told.take());
    (done, told.unwrap_or_default())
}

/// Notes what tools are told, where a test listens.
pub(super) fn tell(what: impl FnOnce() -> Told) {
    REQUEST.with_borrow_mut(|request| {
        if let Some(told) = &mut request.told {
            told.push(what());
        }
    });
}

/// Whether a dispatch of this kernel is to be left out.
pub(super) fn drops(kernel: &str) -> bool {
    REQUEST.with_borrow(|request| request.dropped).is_some_and(|dropped| dropped(kernel))
}

/// Runs `body` while `alter` changes every adapter that is listed on this thread: lower limits, another name.
pub fn on_altered<T>(alter: fn(&mut Adapter), body: impl FnOnce() -> T) -> T {
    REQUEST.with_borrow_mut(|request| request.alter = Some(alter));
    let done = body();
    REQUEST.with_borrow_mut(|request| request.alter = None);
    done
}

/// The adapter, changed as the test on this thread requests.
pub(super) fn altered(mut adapter: Adapter) -> Adapter {
    if let Some(alter) = REQUEST.with_borrow(|request| request.alter) {
        alter(&mut adapter);
    }
    adapter
}

/// Records a call that is about to be made, where a test watches; returns the result code if it is to fail instead.
pub(super) fn inject(name: &'static str, doing: &str) -> Option<vk::Result> {
    REQUEST.with_borrow_mut(|request| {
        let seen = request.seen.as_mut()?;
        seen.push(Call { name, doing: doing.to_string() });
        (request.failing == Some(seen.len() - 1)).then(|| likely_failure(name))
    })
}

/// The result code that a call is most likely to fail with.
fn likely_failure(name: &str) -> vk::Result {
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
