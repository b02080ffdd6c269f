#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Marks every link of each receiver of a chunk as waiting for its form factor.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(order)
READS(spans)
UPDATES(stale)
UPDATES(stale_counts)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = order[range.first + i];
    uint first = spans[receiver].link, count = spans[receiver].links;
    for (uint k = 0; k < count; ++k) stale[first + k] = 1;
    stale_counts[receiver] = count;
}
