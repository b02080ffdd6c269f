#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Shows the environment where a pixel's ray hits nothing, and its sun: a disc, brightest in the middle.
layout(push_constant, scalar) uniform push_block { Light sun; };
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
    if (hits[pixel].face != NONE) return;
    vec3 direction = ray(pixel), off = normalize(direction) - sun.place, seen = sky_toward(direction);
    float share = 1.0 - 0.5 * dot(off, off) / sun.outer;
    if (sun.outer > 0.0 && share > 0.0) seen += share / (PI * sun.outer) * sun.color;
    radiance[pixel] = camera[0].radiance * seen;
}
