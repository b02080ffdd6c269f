#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Multiplies the light that leaves towards the eye by the texture at the point that is seen.
layout(constant_id = 0) const uint OBJECTS = 1;
READS(object_params)
READS(camera)
READS(hits)
READS(corner_uvs)
READS(texels)
UPDATES(radiance)
#include "lighting/texture.glsl"
#include "view/object.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face >= UNFINISHED) return;
    uint object = object_of(hit.face);
    if ((object_params[object].texture_side & TEXTURE_LEAVES) == 0) return;
    radiance[pixel] *= texture_factor(object, texture_place(corner_uvs[hit.face], vec2(hit.u, hit.v)));
}
