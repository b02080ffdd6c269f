#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// How long each block's lists will be.
UPDATES(runs)
UPDATES(cursor)
#include "transport/link/walk.glsl"

const float TORN = 1e30;
const uint MOST_NEAR = 700;
uint count[6] = uint[6](0, 0, 0, 0, 0, 0);
void on_emitter(uint kind, uint node) {
    for (uint k = 0; k < 6; ++k) count[k] += uint(kind == k);
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    bool whole = walk(range.first + i);
    // Of a block that is torn, all triangles round it are near, perhaps more than a driver's loops can take.
    bool torn = spheres[range.first + i].spread >= TORN && count[AREA] + count[EDGE] > MOST_NEAR;
    if (!whole || torn) cursor[0].unfinished = 1;
    runs[i] = Runs(0, count[EXPANDED], count[DIRECT], count[AREA], count[EDGE], count[DROPPED]);
}
