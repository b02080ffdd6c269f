#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Scales the newest vector to length 1, or to 0 where nothing is left of it.
layout(push_constant, scalar) uniform push_block { uint newest; };
READS(object_params)
READS(small_system)
UPDATES(krylov)

void main() {
    uint face = invocation(), faces = object_params[0].faces;
    if (face >= faces) return;
    vec3 square = small_system[SMALL_PRODUCTS + newest];
    vec3 by = mix(vec3(0), inversesqrt(max(square, vec3(1e-37))), greaterThan(square, vec3(1e-37)));
    krylov[newest * faces + face] *= by;
}
