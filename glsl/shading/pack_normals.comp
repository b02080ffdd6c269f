#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The attributes of a vertex that local shading reads, in two words. BENT is 0 if kappa is not needed, 2 if it is
// smoothed, else 1.
layout(constant_id = 0) const uint BENT = 0;
READS(object_params)
READS(placed_normals)
READS(curvature)
READS(smooth_kappa)
WRITES(packed_normals)

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    precise vec3 scaled = floor(placed_normals[vertex] * 32767.0 + 0.5);
    ivec3 normal = ivec3(scaled) & 0xffff;
    uint code = 0;
    if (BENT != 0) {
        float kappa;
        if (BENT == 2) kappa = smooth_kappa[vertex];
        else kappa = curvature[vertex].kappa;
        precise float above = kappa + KAPPA_LEAST;
        code = min(floatBitsToUint(above) - floatBitsToUint(KAPPA_LEAST) + 0x800u >> 12, 0xffffu);
    }
    packed_normals[vertex] = uvec2(normal.x | normal.y << 16, uint(normal.z) | code << 16);
}
