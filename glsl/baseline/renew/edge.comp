#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/edge.glsl"

// The due links that take the edge form: the last ones.
READS(cursor)
READS(ranked)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].due_edges) return;
    uint at = ranked[cursor[0].due - cursor[0].due_edges + i];
    factors[at] = edge_factor(at);
}
