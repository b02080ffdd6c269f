#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A cluster's light has changed if a child's has.
READS(topology)
SHARES(change_flags)
#include "climb.glsl"

void of_cluster(uint node, uint right) {
    change_flags[node] |= change_flags[node + 1] | change_flags[right];
}
