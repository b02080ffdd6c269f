#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The sum of `collect`, for the receivers in `busy` only.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(cursor)
READS(busy)
READS(spans)
READS(links)
READS(factors)
READS(cluster_irradiance)
UPDATES(gathered)

void main() {
    uint i = invocation();
    if (i >= cursor[0].busy) return;
    uint receiver = busy[range.first + i];
    uint first = spans[receiver].link, last = first + spans[receiver].links;
    vec3 sum = vec3(0);
    for (uint k = first; k < last; ++k) sum += cluster_irradiance[links[k].emitter] * factors[k];
    gathered[receiver] = sum;
}
