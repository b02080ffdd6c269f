#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The light that an opaque face reflects diffusely.
READS(object_params)
READS(irradiance)
WRITES(radiosity)

void main() {
    uint face = invocation();
    if (face < object_params[0].faces) radiosity[face] = object_params[0].albedo * irradiance[face];
}
