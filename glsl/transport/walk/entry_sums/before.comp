#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Turns the light of each block into the sum over the blocks before it; the entry after the last holds the total.
READS(object_params)
UPDATES(entry_blocks)

void main() {
    uint channel = invocation(), blocks = (object_params[0].faces + ENTRY_BLOCK - 1) / ENTRY_BLOCK;
    if (channel >= 3) return;
    uint low = 0, high = 0, carry;
    for (uint block = 0; block < blocks; ++block) {
        uint own = entry_blocks[block].low[channel], own_high = entry_blocks[block].high[channel];
        entry_blocks[block].low[channel] = low;
        entry_blocks[block].high[channel] = high;
        low = uaddCarry(low, own, carry);
        high += own_high + carry;
    }
    entry_blocks[blocks].low[channel] = low;
    entry_blocks[blocks].high[channel] = high;
}
