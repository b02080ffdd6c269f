#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"
#include "transport/links/form_factor/far.glsl"

// Computes the form factors of the due links that take one sample: the first ones in `ranked_links`.
READS(counters)
READS(ranked_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].due - counters[0].due_areas - counters[0].due_edges) return;
    uint at = ranked_links[i];
    factors[at] = far_factor(at);
}
