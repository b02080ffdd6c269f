#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Products of the newest vector with those before it, or with itself: means over the object's area. One group for each
// product; every PARTS-th face is summed by itself, whatever the size of the group.
layout(constant_id = WIDE_ID) const uint WIDTH = GROUP_SIZE;
layout(local_size_x = GROUP_SIZE, local_size_x_id = WIDE_ID) in;
layout(constant_id = 0) const uint PASS = 0;
layout(push_constant, scalar) uniform push_block { uint newest; uint first; };
READS(object_params)
READS(leaves)
READS(clusters)
READS(krylov)
UPDATES(small_system)

const uint PARTS = MOST_WIDE;
shared vec3 partial[PARTS];

void main() {
    uint vector = first + gl_WorkGroupID.x, faces = object_params[0].faces, self = gl_LocalInvocationIndex;
    for (uint part = self; part < PARTS; part += WIDTH) {
        vec3 sum = vec3(0);
        for (uint face = part; face < faces; face += PARTS) {
            sum += clusters[leaves[face]].area * krylov[vector * faces + face] * krylov[newest * faces + face];
        }
        partial[part] = sum;
    }
    for (uint count = PARTS / 2; count > 0; count /= 2) {
        barrier();
        for (uint part = self; part < count; part += WIDTH) partial[part] += partial[part + count];
    }
    if (self != 0) return;
    vec3 sum = partial[0] / max(clusters[0].area, 1e-37);
    small_system[SMALL_PRODUCTS + vector] = sum;
    // The operator in this basis; the second pass finds what rounding left in the first.
    uint entry = SMALL_MATRIX + (newest - 1) * (MOST_STEPS + 1) + vector;
    if (vector < newest) small_system[entry] = PASS == 0 ? sum : small_system[entry] + sum;
}
