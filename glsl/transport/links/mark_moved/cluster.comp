#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A cluster is altered if one of its children is; one level a dispatch.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(topology)
READS(order)
UPDATES(change_flags)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint node = order[range.first + i];
    change_flags[node] = change_flags[node + 1] | change_flags[topology[node + 1].skip];
}
