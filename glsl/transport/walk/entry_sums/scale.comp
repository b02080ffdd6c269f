#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The largest light of all blocks, in the entry after the last.
READS(object_params)
UPDATES(entry_blocks)

void main() {
    uint channel = invocation(), blocks = (object_params[0].faces + ENTRY_BLOCK - 1) / ENTRY_BLOCK;
    if (channel >= 3) return;
    uint most = 0;
    for (uint block = 0; block < blocks; ++block) most = max(most, entry_blocks[block].most[channel]);
    entry_blocks[blocks].most[channel] = most;
}
