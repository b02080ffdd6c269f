#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The moments of a level's clusters.
layout(constant_id = 0) const uint ORDER = 2;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(topology)
READS(order)
READS(bounds)
READS(clusters)
UPDATES(moments)
UPDATES(second_moments)
#include "transport/blocks/pull/parallel_axes.glsl"

void main() {
    uint i = invocation();
    if (i < range.count) pull(order[range.first + i]);
}
