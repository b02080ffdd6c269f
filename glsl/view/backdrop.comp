#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Shows the environment where a pixel's ray hits nothing.
READS(object_params)
READS(camera)
READS(hits)
READS(sky)
UPDATES(radiance)
#include "view/ray.glsl"
#include "lighting/sky.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    if (hits[pixel].face == NONE) radiance[pixel] = camera[0].radiance * sky_toward(ray(pixel));
}
