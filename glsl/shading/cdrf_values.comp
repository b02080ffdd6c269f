#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "shading/closed.glsl"

// Single values of the CDRF.
READS(queries)
WRITES(answers)

void main() {
    uint k = invocation();
    if (k >= queries.length()) return;
    answers[k] = vec3(cdrf(queries[k].a.x, vec3(queries[k].a.y)).x, 0, 0);
}
