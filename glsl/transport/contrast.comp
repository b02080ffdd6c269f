#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The least step of a fourth of an octave by which the level has to be raised to reach the light that enters, per channel.
// One invocation. Decisions only.
layout(constant_id = 0) const uint CHANNELS = 7;
READS(frame)
READS(samples)
READS(level)
UPDATES(cursor)
#include "transport/channels.glsl"

const uint SAMPLES = 256, STEPS = 112;
const float ROOTS[4] = float[4](1.0, 1.18920712, 1.41421356, 1.68179283);

void main() {
    if (invocation() != 0) return;
    precise float sum = 0.0;
    for (uint k = 0; k < SAMPLES; ++k) sum = sum + samples[k].light;
    precise float mean = sum * (1.0 / 256.0);
    precise vec3 light = mean * (frame[0].tint * frame[0].tint);
    vec3 level_here = level[0], found = vec3(0);
    float octave = 1.0 / 256.0;
    for (uint k = 0; k < STEPS; ++k) {
        float q = octave * ROOTS[k % 4];
        precise vec3 reach = q * level_here;
        precise vec3 reach2 = reach * reach;
        EACH_CHANNEL({ found[c] = found[c] == 0.0 && reach2[c] >= light[c] ? q : found[c]; })
        octave *= k % 4 == 3 ? 2.0 : 1.0;
    }
    EACH_CHANNEL({ found[c] = found[c] == 0.0 ? octave : found[c]; })
    cursor[0].contrast = only_group(found, cursor[0].contrast);
}
