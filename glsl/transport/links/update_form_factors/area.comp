#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"
#include "transport/links/form_factor/area.glsl"

// Computes the form factors of the due links that take area points; `ranked_links` has them after the links that take
// one sample.
READS(counters)
READS(ranked_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].due_areas) return;
    uint at = ranked_links[counters[0].due - counters[0].due_edges - counters[0].due_areas + i];
    factors[at] = area_factor(at);
}
