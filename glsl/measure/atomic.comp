#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device increments words of a buffer; neighbours increment different words.
layout(constant_id = 0) const uint ROUNDS = 1;
layout(set = 0, binding = 0) restrict readonly buffer step_block { uint steps[]; };
layout(set = 0, binding = 1) restrict buffer count_block { uint counts[]; };

void main() {
    uint self = invocation(), count = counts.length(), at = self;
    for (uint round = 0; round < ROUNDS && self < count; ++round) {
        atomicAdd(counts[at], 1);
        at += steps[0];
        at = at < count ? at : at - count;
    }
}
