//! Where objects lie in the scene: what turns and shifts them from the frame in which their light is carried.

use super::units::Units;
use crate::scene::Object;
use crate::state::{State, narrow};
use glam::{DMat3, DVec3};

/// Writes the objects' placements, and tells which differ from before. If any object is turned or shifted, all are
/// placed.
pub fn place(state: &mut State, objects: &[Object], units: Units) -> Vec<bool> {
    let placements: Vec<_> = objects.iter().map(|object| units.placement(object)).collect();
    let placed = placements.iter().any(|placement| *placement != (DMat3::IDENTITY, DVec3::ZERO));
    let parts = state.objects.iter_mut().zip(&mut state.data.object_params);
    let write = |((part, params), (turn, shift)): ((&mut crate::state::Object, &mut _), &(DMat3, DVec3))| {
        let params: &mut crate::layout::ObjectParams = params;
        let before = (part.placed, params.turn_x, params.turn_y, params.turn_z, params.shift);
        [params.turn_x, params.turn_y, params.turn_z] = [0, 1, 2].map(|row| narrow(turn.row(row)));
        params.shift = narrow(*shift);
        part.placed = placed;
        before != (placed, params.turn_x, params.turn_y, params.turn_z, params.shift)
    };
    parts.zip(&placements).map(write).collect()
}
