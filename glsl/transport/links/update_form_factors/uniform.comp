#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"
#include "transport/links/form_factor/uniform.glsl"

// Computes the last ones of the due links by uniform point samples instead of the edge form.
READS(counters)
READS(ranked_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].due_edges) return;
    uint at = ranked_links[counters[0].due - counters[0].due_edges + i];
    factors[at] = uniform_factor(at);
}
