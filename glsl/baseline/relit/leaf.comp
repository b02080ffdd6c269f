#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether the light that enters a triangle differs from that of the last sum.
READS(frame)
READS(leaves)
READS(irradiance)
READS(cluster_irradiance)
UPDATES(altered)

void main() {
    uint face = invocation();
    if (face >= frame[0].faces) return;
    uint leaf = leaves[face];
    if (any(notEqual(irradiance[face], cluster_irradiance[leaf]))) altered[leaf] |= ALTERED_RELIT;
}
