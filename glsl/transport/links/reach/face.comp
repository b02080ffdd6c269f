#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "transport/links/reach/reach.glsl"

// A triangle's reach for each rule of the ladder.
READS(leaves)
READS(clusters)
WRITES(reach)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    float tau = clusters[leaves[face]].moment_trace;
    reach[face] = vec4(reach2(tau, 0), reach2(tau, 1), reach2(tau, 2), reach2(tau, 3));
}
