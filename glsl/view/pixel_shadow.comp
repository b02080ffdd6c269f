#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether one light reaches the points of opaque objects that some pixels show: a bit of `pixel_lit`. Decisions
// only.
layout(constant_id = 0) const uint OBJECTS = 1;
layout(push_constant, scalar) uniform push_block { Rays rays; };
READS(object_params)
READS(lights)
READS(placed_positions)
READS(triangles)
READS(placed_bounds)
READS(hits)
UPDATES(pixel_lit)
UPDATES(cut_short)
#include "geometry/blend.glsl"
#include "lighting/way.glsl"
#include "view/object.glsl"

void main() {
    uint k = invocation();
    if (k >= rays.count) return;
    uint pixel = rays.first + k;
    Hit hit = hits[pixel];
    bool shown = hit.face < UNFINISHED;
    uint face = shown ? hit.face : 0;
    uint object = object_of(face);
    bool asked = shown && object_params[object].opaque == OPAQUE_BY_PIXEL;
    Light light = lights[rays.light];
    uvec3 corner = triangles[face];
    precise vec3 weight = CORNER_WEIGHTS(hit);
    precise vec3 place = BLEND_AT(weight, placed_positions, corner);
    uint met = way(light, object, face, place, asked, false);
    if (met == UNFINISHED) cut_short[0] = 1;

    // The first light of a word clears it.
    uint word = pixel * object_params[0].shadow_words + light.shadow / 32, bit = light.shadow % 32;
    uint others = bit == 0 ? 0 : pixel_lit[word];
    pixel_lit[word] = others | (met == FREE ? 1u << bit : 0u);
}
