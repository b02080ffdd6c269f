#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The moments of a cluster's vertices from its two children's; one level a dispatch.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(topology)
READS(order)
UPDATES(vertex_moments)
#include "layers/vertex_moments.glsl"

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint node = order[range.first + i];
    vertex_moments[node] = joined(vertex_moments[node + 1], vertex_moments[topology[node + 1].skip]);
}
