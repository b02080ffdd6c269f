#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The sphere around each block's receivers.
READS(object_params)
READS(blocks)
READS(clusters)
READS(receiver_positions)
WRITES(spheres)
#include "geometry/sphere.glsl"

void main() {
    uint i = invocation();
    if (i >= object_params[0].blocks) return;
    Block block = blocks[i];
    spheres[i] = sphere_of(block.first, block.count);
}
