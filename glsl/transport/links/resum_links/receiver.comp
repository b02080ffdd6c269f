#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"

// The sum of `sum_links`, for the receivers in `active_receivers` only.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(counters)
READS(active_receivers)
READS(spans)
READS(links)
READS(factors)
READS(cluster_irradiance)
UPDATES(gathered)

void main() {
    uint i = invocation();
    if (i >= counters[0].receivers) return;
    uint receiver = active_receivers[range.first + i];
    uint first = spans[receiver].link, last = first + spans[receiver].links;
    vec3 sum = vec3(0);
    for (uint k = first; k < last; ++k) sum += cluster_irradiance[links[k].emitter] * factors[k];
    gathered[receiver] = sum;
}
