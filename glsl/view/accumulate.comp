#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The mean of a pixel's samples so far.
READS(camera)
READS(radiance)
UPDATES(mean)

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    float weight = camera[0].weight;
    vec3 sample_ = radiance[pixel];
    mean[pixel] = weight == 1.0 ? sample_ : mean[pixel] + weight * (sample_ - mean[pixel]);
}
