#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The sphere round each block's receivers: the middle of the box round their centroids, and the farthest of them.
READS(frame)
READS(blocks)
READS(leaves)
READS(clusters)
WRITES(spheres)

void main() {
    uint i = invocation();
    if (i >= frame[0].blocks) return;
    Block block = blocks[i];
    vec3 low = vec3(1e30), high = vec3(-1e30);
    for (uint k = 0; k < block.count; ++k) {
        vec3 x = clusters[leaves[block.first + k]].center;
        low = min(low, x);
        high = max(high, x);
    }
    vec3 center = 0.5 * (low + high);
    float radius2 = 0.0, spread = 0.0;
    for (uint k = 0; k < block.count; ++k) {
        vec3 d = clusters[leaves[block.first + k]].center - center;
        radius2 = max(radius2, dot(d, d));
        spread += dot(d, d);
    }
    // The usual block: a flat disc of the mean area of all blocks.
    float disc = max(clusters[0].area / (6.2831853 * float(frame[0].blocks)), 1e-30);
    spheres[i] = Sphere(center, sqrt(radius2), spread / (float(block.count) * disc));
}
