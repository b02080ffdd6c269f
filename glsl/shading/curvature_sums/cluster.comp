#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A cluster's curvature measures from its two children's; one level a dispatch.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(topology)
READS(order)
UPDATES(curvature_sums)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint node = order[range.first + i];
    uint left = node + 1, right = topology[left].skip;
    CurvatureSum l = curvature_sums[left], r = curvature_sums[right];
    curvature_sums[node] = CurvatureSum(l.area + r.area, l.mean + r.mean, l.gaussian + r.gaussian);
}
