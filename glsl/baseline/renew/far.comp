#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/far.glsl"

// The due links that take one sample: the first ones.
READS(cursor)
READS(ranked)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].due - cursor[0].due_areas - cursor[0].due_edges) return;
    uint at = ranked[i];
    factors[at] = far_factor(at);
}
