#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The coefficients of the solution, from the triangular system, the last one first; and those of the residual, by the
// rotations backwards. One invocation.
layout(push_constant, scalar) uniform push_block { uint steps; };
UPDATES(small_system)

void main() {
    if (invocation() != 0) return;
    vec3 carried = small_system[SMALL_RIGHT + steps];
    for (uint back = 0; back < steps; ++back) {
        uint k = steps - 1 - back;
        small_system[SMALL_RESIDUAL + k + 1] = small_system[SMALL_COSINES + k] * carried;
        carried *= -small_system[SMALL_SINES + k];
    }
    small_system[SMALL_RESIDUAL] = carried;
    for (uint back = 0; back < steps; ++back) {
        uint k = steps - 1 - back;
        vec3 sum = small_system[SMALL_RIGHT + k];
        for (uint j = k + 1; j < steps; ++j) {
            sum -= small_system[SMALL_MATRIX + j * (MOST_STEPS + 1) + k] * small_system[SMALL_COEFFICIENTS + j];
        }
        vec3 pivot = small_system[SMALL_MATRIX + k * (MOST_STEPS + 1) + k];
        small_system[SMALL_COEFFICIENTS + k] = mix(vec3(0), sum / max(pivot, vec3(1e-30)), greaterThan(pivot, vec3(1e-30)));
    }
}
