#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/uniform.glsl"

// The last of the due links by uniform point samples instead of the edge form.
READS(cursor)
READS(ranked)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].due_edges) return;
    uint at = ranked[cursor[0].due - cursor[0].due_edges + i];
    factors[at] = uniform_factor(at);
}
