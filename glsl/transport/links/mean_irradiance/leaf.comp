#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A leaf's irradiance is its face's.
READS(object_params)
READS(leaves)
READS(irradiance)
WRITES(cluster_irradiance)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    cluster_irradiance[leaves[face]] = irradiance[face];
}
