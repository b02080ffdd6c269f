#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// Work that can be counted by hand: `elements` invocations of `rounds` rounds; every fourth round takes an exponential.
layout(set = 0, binding = 0) restrict readonly buffer size_block { uvec2 size[]; };
layout(set = 0, binding = 1) restrict buffer value_block { float values[]; };

void main() {
    uint self = invocation();
    uvec2 many = size[0];
    if (self >= many.x) return;
    float x = values[self];
    for (uint round = 0; round < many.y; ++round) {
        x = x * 0.75 + 0.25;
        if ((round & 3) == 0) x = exp(-x);
    }
    values[self] = sqrt(x) + dot(vec3(x, 1.0, 2.0), vec3(values[0], x, x));
}
