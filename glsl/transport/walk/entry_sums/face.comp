#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The light of all triangles up to and including each one; and its exits, which start empty.
READS(object_params)
READS(leaves)
READS(clusters)
READS(irradiance)
READS(entry_blocks)
WRITES(entry_sums)
WRITES(exits)
#include "transport/walk/entry_sums/light.glsl"

void main() {
    uint block = invocation(), blocks = entry_block_count();
    if (block >= blocks) return;
    uint first = block * ENTRY_BLOCK, end = min(first + ENTRY_BLOCK, object_params[0].faces);
    uvec3 factor = factors(entry_blocks[blocks].most), carry, none = uvec3(0);
    uvec3 low = entry_blocks[block].low, high = entry_blocks[block].high;
    for (uint face = first; face < end; ++face) {
        low = uaddCarry(low, whole_light(face, factor), carry);
        high += carry;
        entry_sums[face] = EntrySum(low, high);
        exits[face] = ExitSum(none, none, none, none, none, none);
    }
}
