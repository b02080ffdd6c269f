#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "transport/links/form_factor/far.glsl"

// Takes one sample at the emitter's centre for every link; later kernels compute the nearer links again.
READS(counters)
WRITES(factors)

void main() {
    uint i = invocation();
    if (i >= counters[0].links || counters[0].overflow != 0) return;
    factors[i] = far_factor(i);
}
