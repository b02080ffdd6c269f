//! Limits that kernels impose on a mesh, because drivers end long loops.

use crate::error::{Input, Result};
use crate::scene::Scene;

/// Most triangles at a vertex on a device. Kernels loop over them, that of the curvature twice, and llvmpipe ends the
/// loops of an invocation after 65,535 iterations in total.
const MOST_ROUND: u32 = 32_767;

/// An error if an object has a vertex with more triangles than kernels can loop over.
pub fn holds(scene: &Scene) -> Result<()> {
    for (number, object) in scene.objects.iter().enumerate() {
        let round = object.mesh.round().into_iter().max().unwrap_or(0);
        if round > MOST_ROUND {
            let fault = Input::new("too many triangles at one vertex for a device").key(format!("object.{number}"));
            return Err(fault.found(round).expected(format!("at most {MOST_ROUND}; `--device cpu` takes more")).into());
        }
    }
    Ok(())
}
