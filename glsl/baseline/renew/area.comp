#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/area.glsl"

// The due links that take area points: they follow those that take one sample.
READS(cursor)
READS(ranked)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].due_areas) return;
    uint at = ranked[cursor[0].due - cursor[0].due_edges - cursor[0].due_areas + i];
    factors[at] = area_factor(at);
}
