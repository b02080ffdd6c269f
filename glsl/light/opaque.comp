#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Light that an opaque face reflects diffusely.
READS(frame)
READS(irradiance)
WRITES(radiosity)

void main() {
    uint face = invocation();
    if (face < frame[0].faces) radiosity[face] = frame[0].albedo * irradiance[face];
}
