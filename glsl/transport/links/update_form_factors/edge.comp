#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"
#include "transport/links/form_factor/edge.glsl"

// Computes the form factors of the due links that take the edge form: the last ones in `ranked_links`.
READS(counters)
READS(ranked_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].due_edges) return;
    uint at = ranked_links[counters[0].due - counters[0].due_edges + i];
    if (topology[links[at].emitter].face == NONE) return;
    factors[at] = edge_factor(at);
}
