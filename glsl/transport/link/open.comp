#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Starts a frame's lists.
UPDATES(cursor)

void main() {
    if (invocation() == 0) cursor[0] = Cursor(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, cursor[0].padding, cursor[0].more_padding, uvec3(0));
}
