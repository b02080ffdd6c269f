#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

#define LISTS spans
UPDATES(spans)
#include "baseline/refine/scan.glsl"

uvec4 rooms() { return uvec4(frame[0].link_room, frame[0].area_room, frame[0].edge_room, frame[0].hand_room); }

void note(uvec4 total) {
    cursor[0].need_links = max(cursor[0].need_links, total.x);
    cursor[0].need_areas = max(cursor[0].need_areas, total.y);
    cursor[0].need_edges = max(cursor[0].need_edges, total.z);
}
