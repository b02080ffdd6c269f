#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Writes each block's lists where the scan placed them, from what `count` kept, and by another walk beyond that.
READS(runs)
READS(counters)
READS(decisions)
WRITES(entries)
#include "transport/blocks/link/walk.glsl"

uint at[LINK_KINDS];
void on_emitter(uint kind, uint node) {
    uint place = 0;
    for (uint k = LINK_EXPANDED; k <= LINK_EDGE; ++k) place = kind == k ? at[k] : place;
    if (kind != LINK_DROPPED && kind != LINK_OPENED) entries[place] = node;
    for (uint k = LINK_EXPANDED; k <= LINK_EDGE; ++k) at[k] += uint(kind == k);
}

void main() {
    uint i = invocation();
    if (i >= range.count || counters[0].entries > object_params[0].entry_capacity) return;
    Runs one = runs[i];
    at[LINK_EXPANDED] = one.first;
    at[LINK_DIRECT] = one.first + one.expanded;
    at[LINK_AREA] = at[LINK_DIRECT] + one.direct;
    at[LINK_EDGE] = at[LINK_AREA] + one.area;
    uint total = at[LINK_EDGE] + one.edge - one.first;
    uint node = 0, known = min(total, LINK_KEPT - 1);
    for (uint k = 0; k < known; ++k) {
        uint decision = decisions[i * LINK_KEPT + k];
        node = decision & ((1u << LINK_SHIFT) - 1);
        on_emitter(decision >> LINK_SHIFT, node);
    }
    // The walk goes on behind the last of them.
    if (known < total) walk(range.first + i, emitters[node].skip);
}
