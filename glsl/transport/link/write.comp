#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Writes each block's lists where the scan placed them.
READS(runs)
READS(cursor)
WRITES(entries)
#include "transport/link/walk.glsl"

uint at[6];
void on_emitter(uint kind, uint node) {
    uint place = 0;
    for (uint k = EXPANDED; k <= EDGE; ++k) place = kind == k ? at[k] : place;
    if (kind != DROPPED && kind != OPENED) entries[place] = node;
    for (uint k = EXPANDED; k <= EDGE; ++k) at[k] += uint(kind == k);
}

void main() {
    uint i = invocation();
    if (i >= range.count || cursor[0].entries > frame[0].entry_room) return;
    Runs one = runs[i];
    at[EXPANDED] = one.first;
    at[DIRECT] = one.first + one.expanded;
    at[AREA] = at[DIRECT] + one.direct;
    at[EDGE] = at[AREA] + one.area;
    walk(range.first + i);
}
