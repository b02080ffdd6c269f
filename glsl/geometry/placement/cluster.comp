#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The box of a cluster in the scene, from its two children; one level a dispatch.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(topology)
READS(order)
READS(bounds)
UPDATES(placed_bounds)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint node = order[range.first + i];
    uint left = node + 1, right = topology[left].skip;
    vec3 low = min(placed_bounds[left].low, placed_bounds[right].low);
    vec3 high = max(placed_bounds[left].high, placed_bounds[right].high);
    placed_bounds[node] = Bounds(low, bounds[node].next, high, bounds[node].face);
}
