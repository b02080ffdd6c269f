#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Makes the newest column of the small system triangular by rotations; the rest of the right-hand side is then the
// residual's norm, which is NaN if the start has one. At the start the source term's norm is kept, too. One invocation.
layout(constant_id = 0) const uint SOLUTION = 0;
layout(push_constant, scalar) uniform push_block { uint newest; };
UPDATES(small_system)

void main() {
    if (invocation() != 0) return;
    vec3 size = sqrt(small_system[SMALL_PRODUCTS + newest]);
    if (newest == 0) {
        small_system[SMALL_RIGHT] = size;
        small_system[SMALL_NORMS] = SOLUTION == 0 ? size : sqrt(small_system[SMALL_PRODUCTS + 1]);
        small_system[SMALL_NORMS + 1] = size;
        return;
    }
    uint column = SMALL_MATRIX + (newest - 1) * (MOST_STEPS + 1);
    for (uint k = 0; k + 1 < newest; ++k) {
        vec3 c = small_system[SMALL_COSINES + k], s = small_system[SMALL_SINES + k];
        vec3 upper = small_system[column + k], lower = small_system[column + k + 1];
        small_system[column + k] = c * upper + s * lower;
        small_system[column + k + 1] = c * lower - s * upper;
    }
    uint last = newest - 1;
    vec3 upper = small_system[column + last], radius = sqrt(upper * upper + size * size);
    vec3 by = 1.0 / max(radius, vec3(1e-37));
    bvec3 none = lessThanEqual(radius, vec3(1e-37));
    vec3 c = mix(upper * by, vec3(1), none), s = mix(size * by, vec3(0), none);
    small_system[SMALL_COSINES + last] = c;
    small_system[SMALL_SINES + last] = s;
    small_system[column + last] = radius;
    small_system[column + newest] = size;
    vec3 right = small_system[SMALL_RIGHT + last];
    small_system[SMALL_RIGHT + last] = c * right;
    small_system[SMALL_RIGHT + newest] = -s * right;
    small_system[SMALL_NORMS + 1] = abs(s * right);
}
