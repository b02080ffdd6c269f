#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device divides: sixteen quotients a round, each with one addition to a sum and one to its divisor.
layout(constant_id = 0) const uint ROUNDS = 1;
layout(set = 0, binding = 0) restrict readonly buffer step_block { vec2 steps[]; };
layout(set = 0, binding = 1) restrict writeonly buffer sum_block { float sums[]; };

void main() {
    uint self = invocation();
    vec4 width = vec4(steps[0].x), one = vec4(steps[0].y);
    vec4 p = 1.0 + 0.01 * (float(self % 64) + vec4(0, 1, 2, 3)), q = p + 0.04, r = p + 0.08, s = p + 0.12;
    vec4 a = vec4(0), b = vec4(0), c = vec4(0), d = vec4(0);
    for (uint round = 0; round < ROUNDS; ++round) {
        a += one / p;
        b += one / q;
        c += one / r;
        d += one / s;
        p += width;
        q += width;
        r += width;
        s += width;
    }
    vec4 all = (a + b) + (c + d);
    if (self < sums.length()) sums[self] = (all.x + all.y) + (all.z + all.w);
}
