#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device works with integers: a shift, an exclusive or and an addition in each of sixteen chains a round.
layout(constant_id = 0) const uint ROUNDS = 1;
layout(set = 0, binding = 0) restrict readonly buffer term_block { uint terms[]; };
layout(set = 0, binding = 1) restrict writeonly buffer sum_block { uint sums[]; };

void main() {
    uint self = invocation();
    uvec4 p = self % 64 + uvec4(0, 1, 2, 3), q = p + 4, r = p + 8, s = p + 12, b = uvec4(terms[0]);
    for (uint round = 0; round < ROUNDS; ++round) {
        p = (p ^ (p << 5)) + b;
        q = (q ^ (q << 5)) + b;
        r = (r ^ (r << 5)) + b;
        s = (s ^ (s << 5)) + b;
    }
    uvec4 all = (p ^ q) ^ (r ^ s);
    if (self < sums.length()) sums[self] = (all.x ^ all.y) ^ (all.z ^ all.w);
}
