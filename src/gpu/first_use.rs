//! Kernels that are about to run for the first time, compiled on all cores.
//!
//! llvmpipe compiles a kernel when it is first dispatched, one after the other on the queue's thread. What it has
//! compiled it keeps on disk, for all devices. So a device opened once more on each core dispatches its share of the
//! new kernels with no groups, and the frame that follows finds all of them compiled.

use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{Builder, available_parallelism};
use std::time::{Duration, Instant};

use super::choices::Choices;
use super::encode::Encoded;
use super::kernel::{Kernel, KernelKey, words_for};
use super::list::{BoundRange, Entry, Groups, Listed};
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use super::reflect::words_of;
use crate::error::Result;
use crate::phases::phase;

/// A kernel that takes less is not compiled but read from the driver's cache.
const COMPILED: Duration = Duration::from_millis(15);
/// After this many kernels that were read, the threads stop: the largest come first, so the others are in the driver's
/// cache, too.
const READ: usize = 2;
/// Maximum number of devices.
const MOST: usize = 16;
/// Bytes of the buffer that is bound everywhere.
const BOUND: u64 = 1 << 16;

/// Kernels that this process has dealt with, by adapter.
static KNOWN: Mutex<BTreeSet<(String, KernelKey)>> = Mutex::new(BTreeSet::new());

/// Has the kernels of a list compiled that are new to this process, if that is any use.
pub(super) fn compile(device: &LogicalDevice, list: &[Entry]) {
    let adapter = device.adapter();
    let kept = std::env::var_os("MESA_SHADER_CACHE_DISABLE").is_none() && adapter.is_llvmpipe();
    if !kept || !device.compiles_ahead() || device.instance().validates() || *device.choices() != Choices::default() {
        return;
    }
    let Ok(mut known) = KNOWN.lock() else { return };
    let mut new: Vec<KernelKey> = Vec::new();
    for entry in list {
        let Entry::Dispatch(Listed { kernel, .. }) = entry else { continue };
        let key = KernelKey { name: kernel.name.clone(), constants: kernel.constants.clone() };
        if kernel.built && kernel.meter.is_none() && known.insert((adapter.name.clone(), key.clone())) {
            new.push(key);
        }
    }
    drop(known);
    let cores = available_parallelism().map_or(1, usize::from).min(new.len()).min(MOST);
    if cores < 2 {
        return;
    }
    new.sort_by_cached_key(|key| std::cmp::Reverse(words_of(&key.name).map_or(0, |words| words.len())));
    let (instance, extras, patience) = (device.instance(), device.extras(), device.patience());
    let (next, read) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || -> Result<()> {
        let device = LogicalDevice::open(instance, adapter, &Choices::default(), extras)?;
        device.wait_at_most(patience);
        let bound = Buffer::new(&device, "bound at first use", BOUND)?;
        while read.load(Ordering::Relaxed) < READ
            && let Some(key) = new.get(next.fetch_add(1, Ordering::Relaxed))
        {
            let took = dispatch_nothing(&device, &bound, key)?;
            read.fetch_add((took < COMPILED).into(), Ordering::Relaxed);
        }
        Ok(())
    };
    // A failure costs time at most: the frame compiles what is left.
    phase("compiling kernels", || {
        std::thread::scope(|scope| {
            for _ in 0..cores {
                // A thread that the system refuses is one fewer.
                drop(Builder::new().spawn_scoped(scope, || drop(work())));
            }
        });
    });
}

/// Dispatches no groups of a kernel, and returns how long that takes.
fn dispatch_nothing(device: &LogicalDevice, bound: &Buffer, key: &KernelKey) -> Result<Duration> {
    let kernel = Rc::new(Kernel::new(device, &key.name, words_for(device, &key.name)?, &key.constants)?);
    let range = BoundRange { buffer: bound.raw, number: bound.number, offset: 0, size: BOUND };
    let ranges = vec![range; kernel.accesses.len()];
    let push = vec![0; kernel.push_bytes as usize];
    let listed = Listed { kernel, ranges, push, groups: Groups::Direct([0; 3]) };
    let encoded = Encoded::new(device, vec![Entry::Dispatch(listed)], 0, Vec::new())?;
    let begin = Instant::now();
    encoded.run()?;
    Ok(begin.elapsed())
}
