#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The solution, and radiosity, which is nowhere negative; and an estimate of the error, from the equation's residual.
layout(constant_id = 0) const uint SOLUTION = 0;
layout(constant_id = 1) const uint ESTIMATE = 0;
layout(push_constant, scalar) uniform push_block { uint steps; };
READS(object_params)
READS(krylov)
READS(small_system)
UPDATES(solution)
UPDATES(estimate)
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
    if (ESTIMATE != 0) {
        vec3 left = vec3(0);
        for (uint k = 0; k <= steps; ++k) left += small_system[SMALL_RESIDUAL + k] * krylov[k * faces + face];
        vec3 clusters = CLUSTER_SHARE * object_params[0].link_error * (abs(value) + small_system[SMALL_NORMS]);
        estimate[face] = 2.0 * abs(left) + RESIDUAL_SPREAD * small_system[SMALL_NORMS + 1] + clusters;
    }
}
