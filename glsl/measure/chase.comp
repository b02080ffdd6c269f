#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device serves loads of 16 bytes each of which says where the next one is, anywhere in the buffer.
layout(constant_id = 0) const uint ROUNDS = 1;
layout(set = 0, binding = 0) restrict readonly buffer ring_block { uvec4 ring[]; };
layout(set = 0, binding = 1) restrict writeonly buffer last_block { uint last[]; };

void main() {
    uint self = invocation();
    uvec4 at = uvec4(self % ring.length(), 0, 0, 0);
    for (uint round = 0; round < ROUNDS; ++round) {
        uvec4 next = ring[at.x];
        at = uvec4(next.x, at.yzw ^ next.yzw);
    }
    if (self < last.length()) last[self] = (at.x ^ at.y) ^ (at.z ^ at.w);
}
