#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device multiplies and adds: a step of sixteen chains a round, none of which waits for another.
layout(constant_id = 0) const uint ROUNDS = 1;
layout(set = 0, binding = 0) restrict readonly buffer term_block { vec2 terms[]; };
layout(set = 0, binding = 1) restrict writeonly buffer sum_block { float sums[]; };

void main() {
    uint self = invocation();
    vec4 a = vec4(terms[0].x), b = vec4(terms[0].y);
    vec4 p = float(self % 64) + vec4(0, 1, 2, 3), q = p + 4.0, r = p + 8.0, s = p + 12.0;
    for (uint round = 0; round < ROUNDS; ++round) {
        p = fma(p, a, b);
        q = fma(q, a, b);
        r = fma(r, a, b);
        s = fma(s, a, b);
    }
    vec4 all = (p + q) + (r + s);
    if (self < sums.length()) sums[self] = (all.x + all.y) + (all.z + all.w);
}
