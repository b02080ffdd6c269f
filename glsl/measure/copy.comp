#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

// How fast the device copies: each invocation copies 64 bytes, neighbours of a group next to each other.
layout(set = 0, binding = 0) restrict readonly buffer from_block { uvec4 from[]; };
layout(set = 0, binding = 1) restrict writeonly buffer to_block { uvec4 to[]; };

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint first = 4 * gl_WorkGroupSize.x * group + gl_LocalInvocationIndex;
    if (first + 3 * gl_WorkGroupSize.x >= to.length()) return;
    uvec4 a = from[first], b = from[first + gl_WorkGroupSize.x];
    uvec4 c = from[first + 2 * gl_WorkGroupSize.x], d = from[first + 3 * gl_WorkGroupSize.x];
    to[first] = a;
    to[first + gl_WorkGroupSize.x] = b;
    to[first + 2 * gl_WorkGroupSize.x] = c;
    to[first + 3 * gl_WorkGroupSize.x] = d;
}
