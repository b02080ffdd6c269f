#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// How long each block's lists will be, and what is in them, in the order of the walk.
UPDATES(runs)
UPDATES(counters)
WRITES(decisions)
#include "transport/blocks/link/walk.glsl"

uint count[LINK_KINDS] = uint[LINK_KINDS](0, 0, 0, 0, 0, 0);
uint first, kept = 0;
void on_emitter(uint kind, uint node) {
    // What is not kept is overwritten by what follows.
    decisions[first + min(kept, LINK_KEPT - 1)] = kind << LINK_SHIFT | node;
    kept += uint(kind != LINK_DROPPED && kind != LINK_OPENED);
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] += uint(kind == k);
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    first = i * LINK_KEPT;
    bool whole = walk(range.first + i, 0);
    if (!whole || count[LINK_DIRECT] > MOST_DIRECT) counters[0].unfinished = 1;
    runs[i] = Runs(0, count[LINK_EXPANDED], count[LINK_DIRECT], count[LINK_AREA],
                   count[LINK_EDGE], count[LINK_DROPPED]);
}
