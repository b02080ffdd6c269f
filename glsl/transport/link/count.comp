#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// How long each block's lists will be.
UPDATES(runs)
UPDATES(cursor)
#include "transport/link/walk.glsl"

// More would be more steps of `gather` than lavapipe's loops take: 65,535, a ninth of them to load.
const uint MOST_DIRECT = 58000;
uint count[6] = uint[6](0, 0, 0, 0, 0, 0);
void on_emitter(uint kind, uint node) {
    for (uint k = 0; k < 6; ++k) count[k] += uint(kind == k);
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    bool whole = walk(range.first + i);
    if (!whole || count[DIRECT] > MOST_DIRECT) cursor[0].unfinished = 1;
    runs[i] = Runs(0, count[EXPANDED], count[DIRECT], count[AREA], count[EDGE], count[DROPPED]);
}
