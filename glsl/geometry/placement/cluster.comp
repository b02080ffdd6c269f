#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The box of a cluster in the scene, from its two children.
READS(topology)
READS(bounds)
SHARES(placed_bounds)
#include "climb.glsl"

void of_cluster(uint node, uint right) {
    uint left = node + 1;
    vec3 low = min(placed_bounds[left].low, placed_bounds[right].low);
    vec3 high = max(placed_bounds[left].high, placed_bounds[right].high);
    placed_bounds[node] = Bounds(low, bounds[node].next, high, bounds[node].face);
}
