#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "transport/links/form_factor/projected.glsl"

// Computes the form factors of the clusters among the links that take the edge form.
READS(counters)
READS(edge_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].edges || counters[0].overflow != 0) return;
    if (topology[links[edge_links[i]].emitter].face != NONE) return;
    factors[edge_links[i]] = projected_factor(edge_links[i]);
}
