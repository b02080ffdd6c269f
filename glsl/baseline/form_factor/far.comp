#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "baseline/form_factor/far.glsl"

// One sample at the emitter's centre for every link; the nearer ones are computed again after.
READS(cursor)
WRITES(factors)

void main() {
    uint i = invocation();
    if (i >= cursor[0].links || cursor[0].overflow != 0) return;
    factors[i] = far_factor(i);
}
