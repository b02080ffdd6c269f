#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A cluster's irradiance is the area-weighted mean of its children's; one level a dispatch.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(topology)
READS(order)
READS(clusters)
UPDATES(cluster_irradiance)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint node = order[range.first + i];
    uint left = node + 1, right = topology[left].skip;
    float whole = clusters[left].area + clusters[right].area;
    float share = whole > 0.0 ? clusters[right].area / whole : 0.5;
    cluster_irradiance[node] = mix(cluster_irradiance[left], cluster_irradiance[right], share);
}
