#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Subtracts from the newest vector its projections on the vectors before it.
layout(push_constant, scalar) uniform push_block { uint newest; };
READS(object_params)
READS(small_system)
UPDATES(krylov)

void main() {
    uint face = invocation(), faces = object_params[0].faces;
    if (face >= faces) return;
    vec3 value = krylov[newest * faces + face];
    for (uint vector = 0; vector < newest; ++vector) {
        value -= small_system[SMALL_PRODUCTS + vector] * krylov[vector * faces + face];
    }
    krylov[newest * faces + face] = value;
}
