#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Sums of SKY_BLOCK blocks each, one harmonic an invocation. The sums lie before the blocks.
layout(push_constant, scalar) uniform push_block { Range range; }; // the sums; the blocks follow
layout(constant_id = 0) const uint BLOCKS = 0;
UPDATES(harmonics)

void main() {
    uint k = invocation();
    if (k >= SKY_HARMONICS * range.count) return;
    uint sum = k / SKY_HARMONICS, harmonic = k % SKY_HARMONICS, blocks = range.first + range.count;
    uint end = min(SKY_BLOCK * sum + SKY_BLOCK, BLOCKS);
    vec3 total = vec3(0);
    for (uint i = SKY_BLOCK * sum; i < end; ++i) total += harmonics[SKY_HARMONICS * (blocks + i) + harmonic];
    harmonics[SKY_HARMONICS * (range.first + sum) + harmonic] = total;
}
