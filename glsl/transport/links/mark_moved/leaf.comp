#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether a corner of a triangle has moved since its links were made.
READS(object_params)
READS(positions)
READS(kept_positions)
READS(triangles)
READS(leaves)
WRITES(change_flags)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uvec3 corner = triangles[face];
    bool moved = false;
    for (uint k = 0; k < 3; ++k) moved = moved || any(notEqual(positions[corner[k]], kept_positions[corner[k]]));
    change_flags[leaves[face]] = moved ? ALTERED_MOVED : 0;
}
