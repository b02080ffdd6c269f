#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

#define LISTS spans
UPDATES(spans)
#include "transport/links/refine/scan_lists.glsl"

uvec4 rooms() { return uvec4(object_params[0].link_capacity, object_params[0].area_capacity, object_params[0].edge_capacity, object_params[0].hand_capacity); }

void note(uvec4 total) {
    counters[0].required_links = max(counters[0].required_links, total.x);
    counters[0].required_areas = max(counters[0].required_areas, total.y);
    counters[0].required_edges = max(counters[0].required_edges, total.z);
}
