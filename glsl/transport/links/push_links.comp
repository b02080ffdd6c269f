#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// B of a face is the sum of the light gathered at its leaf and at every cluster above it.
READS(object_params)
READS(topology)
READS(leaves)
READS(gathered)
WRITES(radiosity)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    vec3 sum = vec3(0);
    for (uint node = leaves[face]; node != NONE; node = topology[node].parent) sum += gathered[node];
    radiosity[face] = sum;
}
