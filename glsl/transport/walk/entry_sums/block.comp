#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The light of each block of triangles, in integers.
READS(object_params)
READS(leaves)
READS(clusters)
READS(irradiance)
UPDATES(entry_blocks)
#include "transport/walk/entry_sums/light.glsl"

void main() {
    uint block = invocation(), blocks = entry_block_count();
    if (block >= blocks) return;
    uint first = block * ENTRY_BLOCK, end = min(first + ENTRY_BLOCK, object_params[0].faces);
    uvec3 factor = factors(entry_blocks[blocks].most), low = uvec3(0), high = uvec3(0), carry;
    for (uint face = first; face < end; ++face) {
        low = uaddCarry(low, whole_light(face, factor), carry);
        high += carry;
    }
    entry_blocks[block].low = low;
    entry_blocks[block].high = high;
}
