#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether another light enters a triangle than the one that was summed last.
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
