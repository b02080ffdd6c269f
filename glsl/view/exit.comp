#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Light that leaves towards the eye times the texture at the place that is seen.
READS(frame)
READS(camera)
READS(hits)
READS(corner_uvs)
READS(texels)
UPDATES(radiance)
#include "light/texture.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face >= frame[0].faces || (frame[0].texture_side & 2) == 0) return;
    radiance[pixel] *= texture_factor(texture_place(corner_uvs[hit.face], vec2(hit.u, hit.v)));
}
