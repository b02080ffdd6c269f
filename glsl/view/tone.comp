#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Each pixel's shown value: how many of the thresholds each channel reaches. Decisions only.
layout(constant_id = 0) const uint MEAN = 0; // not 0 where there are several samples a pixel
READS(camera)
READS(radiance)
READS(mean)
READS(tones)
WRITES(shown)

// A binary search: 255 thresholds take 8 steps.
uint step_of(float x) {
    uint reached = 0;
    for (uint half_ = 128; half_ > 0; half_ /= 2) reached += tones[reached + half_ - 1] <= x ? half_ : 0;
    return reached;
}

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    vec3 light = radiance[pixel];
    if (MEAN != 0) light = mean[pixel];
    shown[pixel] = step_of(light.r) | step_of(light.g) << 8 | step_of(light.b) << 16;
}
