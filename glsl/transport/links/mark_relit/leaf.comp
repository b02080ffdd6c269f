#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether the light that enters a triangle differs from that at the last sum.
READS(object_params)
READS(leaves)
READS(irradiance)
READS(cluster_irradiance)
UPDATES(change_flags)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uint leaf = leaves[face];
    if (any(notEqual(irradiance[face], cluster_irradiance[leaf]))) change_flags[leaf] |= ALTERED_RELIT;
}
