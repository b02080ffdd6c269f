#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The least factor, in steps of a fourth of an octave, that raises the reference level to the light that enters, per
// channel. One invocation. Decisions only.
layout(constant_id = 0) const uint CHANNELS = 7;
READS(object_params)
READS(samples)
READS(reference_level)
READS(clusters)
READS(moments)
UPDATES(counters)
#include "transport/blocks/channels.glsl"

void main() {
    if (invocation() != 0) return;
    precise float sum = 0.0;
    for (uint k = 0; k < COARSE_SAMPLES; ++k) sum = sum + samples[k].light;
    precise float mean = sum * (1.0 / float(COARSE_SAMPLES));
    // Scaled by a power of two before it is squared, so that nothing underflows however dim an object is.
    float whole = moments[0].weight, scale = 1.0;
    for (uint k = 0; k < CONTRAST_DOUBLINGS; ++k) {
        precise float scaled = whole * scale;
        scale *= scaled < 1.0 ? 2.0 : 1.0;
    }
    precise vec3 enters = (whole * scale) * object_params[0].tint, comes = (reference_level[0] * scale) * clusters[0].area;
    precise vec3 light = mean * (enters * enters);
    vec3 found = vec3(0);
    float octave = CONTRAST_LEAST;
    for (uint k = 0; k < CONTRAST_STEPS; ++k) {
        float q = octave * CONTRAST_ROOTS[k % 4];
        precise vec3 reach = q * comes;
        precise vec3 reach2 = reach * reach;
        EACH_CHANNEL({ found[c] = found[c] == 0.0 && reach2[c] >= light[c] ? q : found[c]; })
        octave *= k % 4 == 3 ? 2.0 : 1.0;
    }
    EACH_CHANNEL({ found[c] = found[c] == 0.0 ? octave : found[c]; })
    counters[0].contrast = only_group(found, counters[0].contrast);
}
