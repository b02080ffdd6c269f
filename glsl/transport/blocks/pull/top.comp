#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The moments of the clusters of the upper levels, by one group: these levels have few clusters, and a dispatch for
// each level would wait for the one before.
const uint TOP_GROUP = 128; // every device allows groups of this size
layout(local_size_x = TOP_GROUP) in;
layout(constant_id = 0) const uint ORDER = 2;
layout(push_constant, scalar) uniform push_block { uint count; Range levels[TOP_LEVELS]; };
READS(object_params)
READS(topology)
READS(order)
READS(bounds)
READS(clusters)
SHARES(moments)
SHARES(second_moments)
#include "transport/blocks/pull/parallel_axes.glsl"

void main() {
    // Push constants are read by constant indices only.
    Range own[TOP_LEVELS];
    [[unroll]] for (uint k = 0; k < TOP_LEVELS; ++k) own[k] = levels[k];
    for (uint level = 0; level < count; ++level) {
        Range range = own[level];
        for (uint i = gl_LocalInvocationIndex; i < range.count; i += TOP_GROUP) pull(order[range.first + i]);
        memoryBarrierBuffer();
        barrier();
        memoryBarrierBuffer();
    }
}
