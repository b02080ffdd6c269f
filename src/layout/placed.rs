//! Places in the scene: buffers of their own where objects are turned or shifted, else those of the objects' frames.

use super::{Bounds, BufferId, Buffers};

impl Buffers {
    /// Positions in the scene.
    #[must_use]
    pub fn in_scene(&self) -> &[[f32; 3]] {
        if self.placed_positions.is_empty() { &self.positions } else { &self.placed_positions }
    }

    /// Vertex normals in the scene.
    #[must_use]
    pub fn normals_in_scene(&self) -> &[[f32; 3]] {
        if self.placed_normals.is_empty() { &self.normals } else { &self.placed_normals }
    }

    /// Bounding boxes in the scene.
    #[must_use]
    pub fn bounds_in_scene(&self) -> &[Bounds] {
        if self.placed_bounds.is_empty() { &self.bounds } else { &self.placed_bounds }
    }

    /// The buffer that is bound where a kernel names this one.
    #[must_use]
    pub fn bound(&self, id: BufferId) -> BufferId {
        match id {
            BufferId::placed_positions if self.placed_positions.is_empty() => BufferId::positions,
            BufferId::placed_normals if self.placed_normals.is_empty() => BufferId::normals,
            BufferId::placed_bounds if self.placed_bounds.is_empty() => BufferId::bounds,
            other => other,
        }
    }
}
