#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// Chains that can be counted by hand: invocation k follows a list for `rounds` + k steps, each of which waits for the
// one before it, and then two more; one load beside them waits for none.
layout(set = 0, binding = 0) restrict readonly buffer size_block { uvec2 size[]; };
layout(set = 0, binding = 1) restrict readonly buffer next_block { uint next[]; };
layout(set = 0, binding = 2) restrict writeonly buffer found_block { uint found[]; };

void main() {
    uint self = invocation();
    uvec2 many = size[0];
    if (self >= many.x) return;
    uint at = self;
    for (uint round = 0; round < many.y + self; ++round) at = next[at];
    found[self] = next[next[at]] + next[self];
}
