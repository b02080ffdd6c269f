#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device serves loads of shared memory each of which says where the next one is.
layout(constant_id = 0) const uint ROUNDS = 1;
layout(set = 0, binding = 0) restrict readonly buffer ring_block { uint ring[]; };
layout(set = 0, binding = 1) restrict writeonly buffer last_block { uint last[]; };
shared uint own[1024];

void main() {
    for (uint k = gl_LocalInvocationIndex; k < 1024; k += gl_WorkGroupSize.x) own[k] = ring[k];
    barrier();
    uint self = invocation(), at = self % 1024;
    for (uint round = 0; round < ROUNDS; ++round) at = own[at];
    if (self < last.length()) last[self] = at;
}
