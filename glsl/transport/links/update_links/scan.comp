#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

#define LISTS edits
UPDATES(edits)
#include "transport/links/refine/scan_lists.glsl"

// New links among those that are made are only counted.
uvec4 rooms() { return uvec4(uvec2(object_params[0].edit_capacity), NONE, object_params[0].hand_capacity); }

void note(uvec4 total) { counters[0].required_entries = max(counters[0].required_entries, max(total.x, total.y)); }
