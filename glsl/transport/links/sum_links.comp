#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The light that a node gathers by its own links: the emitters' irradiance times the form factors, in the links' order.
// None if the lists overflowed, since their form factors are not computed: the frame then runs again.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(counters)
READS(order)
READS(spans)
READS(links)
READS(factors)
READS(cluster_irradiance)
UPDATES(gathered)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = order[range.first + i];
    uint first = spans[receiver].link, last = first + (counters[0].overflow == 0 ? spans[receiver].links : 0);
    vec3 sum = vec3(0);
    for (uint k = first; k < last; ++k) sum += cluster_irradiance[links[k].emitter] * factors[k];
    gathered[receiver] = sum;
}
