#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The solution, and radiosity, which is nowhere negative.
layout(constant_id = 0) const uint SOLUTION = 0;
layout(push_constant, scalar) uniform push_block { uint steps; };
READS(object_params)
READS(krylov)
READS(small_system)
UPDATES(solution)
WRITES(radiosity)

void main() {
    uint face = invocation(), faces = object_params[0].faces;
    if (face >= faces) return;
    vec3 value = SOLUTION != 0 ? solution[face] : vec3(0);
    for (uint k = 0; k < steps; ++k) {
        value += small_system[SMALL_COEFFICIENTS + k] * krylov[k * faces + face];
    }
    solution[face] = value;
    radiosity[face] = max(value, vec3(0));
}
