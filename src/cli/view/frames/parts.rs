//! How long the parts are in which something long is made.

use std::time::Duration;

use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::Options;
use milkglass::internals::session::run::{CapacityHints, Session};
use milkglass::scene::Scene;

/// How long something long is gone on with before input is read again; a dispatch is not cut in pieces.
pub(super) const PART: Duration = Duration::from_millis(40);

/// Blocks of receivers whose lists are made and summed in one dispatch, for whose end input waits, where the device is
/// the processor: 8,192 receivers keep its cores busy.
const BATCH: usize = 128;

/// Opens a session that works in short dispatches; its results are those of [`Session::new`].
pub(super) fn open(scene: &Scene, device: &Device, options: Options) -> Result<Session> {
    let room = CapacityHints::default();
    let batch_blocks = if device.adapter().kind == "cpu" { BATCH } else { room.batch_blocks };
    Session::with_capacity(scene, Some(device), options, CapacityHints { batch_blocks, ..room })
}
