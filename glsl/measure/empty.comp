#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// Measures the cost of a dispatch that does nothing. The host dispatches a single group, so that nothing is ever
// written; but both buffers count as written, and a dispatch that shares one with an earlier dispatch has to wait.
layout(set = 0, binding = 0) restrict writeonly buffer first_block { uint first[]; };
layout(set = 0, binding = 1) restrict writeonly buffer second_block { uint second[]; };

void main() {
    if (gl_WorkGroupID.x == 0u) return;
    first[0] = 0u;
    second[0] = 0u;
}
