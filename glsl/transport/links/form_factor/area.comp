#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "transport/links/form_factor/area.glsl"

READS(counters)
READS(area_links)
UPDATES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].areas || counters[0].overflow != 0) return;
    factors[area_links[i]] = area_factor(area_links[i]);
}
