#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/uniform.glsl"

READS(cursor)
READS(edge_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].edges || cursor[0].overflow != 0) return;
    factors[edge_links[i]] = uniform_factor(edge_links[i]);
}
