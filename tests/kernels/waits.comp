#version 460
#extension GL_GOOGLE_include_directive : require

// Waits in a group that can be counted by hand: three barriers, and a load of shared memory after the first and the
// last.
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) restrict readonly buffer size_block { uvec2 size[]; };
layout(set = 0, binding = 1) restrict writeonly buffer found_block { uint found[]; };
shared uint held[64];

void main() {
    uint self = gl_LocalInvocationIndex;
    held[self] = size[0].x + self;
    barrier();
    uint next = held[(self + 1) % 64];
    barrier();
    held[self] = next;
    barrier();
    found[self] = held[(self + 2) % 64];
}
