#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The box of a triangle in the scene.
READS(object_params)
READS(placed_positions)
READS(triangles)
READS(leaves)
READS(bounds)
WRITES(placed_bounds)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uvec3 corner = triangles[face];
    vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
    uint node = leaves[face];
    placed_bounds[node] = Bounds(min(min(a, b), c), bounds[node].next, max(max(a, b), c), bounds[node].face);
}
