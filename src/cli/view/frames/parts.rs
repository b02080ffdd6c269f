//! How long the parts are in which long work is done.

use std::time::Duration;

use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::Options;
use milkglass::internals::session::run::{CapacityHints, Session};
use milkglass::scene::Scene;

/// How long work goes on before input is read again; a dispatch is not cut into parts.
pub(super) const PART: Duration = Duration::from_millis(40);

/// Blocks of receivers whose lists are made and summed in one dispatch, if the device is the processor. Input waits for
/// the end of a dispatch; up to 2,048 receivers keep the cores busy.
const BATCH: usize = 128;

/// Opens a session that works in short dispatches; its results are those of [`Session::new`].
pub(super) fn open(scene: &Scene, device: &Device, options: Options) -> Result<Session> {
    let room = CapacityHints::default();
    let batch_blocks = if device.adapter().kind == "cpu" { BATCH } else { room.batch_blocks };
    Session::with_capacity(scene, Some(device), options, CapacityHints { batch_blocks, ..room })
}
