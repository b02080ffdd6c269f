#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/area.glsl"

READS(cursor)
READS(area_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].areas || cursor[0].overflow != 0) return;
    factors[area_links[i]] = area_factor(area_links[i]);
}
