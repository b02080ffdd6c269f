#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The largest light that enters a triangle, for each block of triangles.
READS(object_params)
READS(leaves)
READS(clusters)
READS(irradiance)
WRITES(entry_blocks)
#include "transport/walk/entry_sums/light.glsl"

void main() {
    uint block = invocation();
    if (block >= entry_block_count()) return;
    uint first = block * ENTRY_BLOCK, end = min(first + ENTRY_BLOCK, object_params[0].faces);
    uvec3 most = uvec3(0);
    for (uint face = first; face < end; ++face) most = max(most, floatBitsToUint(entering_light(face)));
    entry_blocks[block].most = most;
}
