#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// How long each block's lists will be.
UPDATES(runs)
UPDATES(counters)
#include "transport/blocks/link/walk.glsl"

uint count[LINK_KINDS] = uint[LINK_KINDS](0, 0, 0, 0, 0, 0);
void on_emitter(uint kind, uint node) {
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] += uint(kind == k);
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    bool whole = walk(range.first + i);
    if (!whole || count[LINK_DIRECT] > MOST_DIRECT) counters[0].unfinished = 1;
    runs[i] = Runs(0, count[LINK_EXPANDED], count[LINK_DIRECT], count[LINK_AREA],
                   count[LINK_EDGE], count[LINK_DROPPED]);
}
