#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Products of the newest vector with those before it, or with itself: means over the object's area. One group for each
// product.
layout(local_size_x = GROUP_SIZE) in;
layout(constant_id = 0) const uint PASS = 0;
layout(push_constant, scalar) uniform push_block { uint newest; uint first; };
READS(object_params)
READS(leaves)
READS(clusters)
READS(krylov)
UPDATES(small_system)
#include "transport/diffusion/krylov_step/sum.glsl"

void main() {
    uint vector = first + gl_WorkGroupID.x, faces = object_params[0].faces;
    vec3 sum = vec3(0);
    for (uint face = gl_LocalInvocationIndex; face < faces; face += GROUP_SIZE) {
        sum += clusters[leaves[face]].area * krylov[vector * faces + face] * krylov[newest * faces + face];
    }
    sum = sum_of_group(sum) / max(clusters[0].area, 1e-37);
    if (gl_LocalInvocationIndex != 0) return;
    small_system[SMALL_PRODUCTS + vector] = sum;
    // The operator in this basis; the second pass finds what rounding left in the first.
    uint entry = SMALL_MATRIX + (newest - 1) * (MOST_STEPS + 1) + vector;
    if (vector < newest) small_system[entry] = PASS == 0 ? sum : small_system[entry] + sum;
}
