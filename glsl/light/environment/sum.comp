#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Sums of 64 blocks each, one harmonic an invocation. The sums lie before the blocks.
layout(push_constant, scalar) uniform push_block { Range range; }; // the sums; the blocks follow
layout(constant_id = 0) const uint BLOCKS = 0;
UPDATES(harmonics)

void main() {
    uint k = invocation();
    if (k >= 9 * range.count) return;
    uint sum = k / 9, harmonic = k % 9, blocks = range.first + range.count;
    uint end = min(64 * sum + 64, BLOCKS);
    vec3 total = vec3(0);
    for (uint i = 64 * sum; i < end; ++i) total += harmonics[9 * (blocks + i) + harmonic];
    harmonics[9 * (range.first + sum) + harmonic] = total;
}
