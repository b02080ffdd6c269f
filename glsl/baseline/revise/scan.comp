#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

#define LISTS edits
UPDATES(edits)
#include "baseline/refine/scan.glsl"

// New links among those that are made are only counted.
uvec4 rooms() { return uvec4(uvec2(frame[0].edit_room), NONE, frame[0].hand_room); }

void note(uvec4 total) { cursor[0].need_entries = max(cursor[0].need_entries, max(total.x, total.y)); }
