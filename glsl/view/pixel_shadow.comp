#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether one light reaches the points that some pixels show, or the environment along one ray of their reflections: a
// bit of `pixel_lit`. Decisions only.
layout(constant_id = 0) const uint OBJECTS = 1;
layout(constant_id = 1) const uint OTHERS = 0; // not 0 where a translucent object does not shadow itself
layout(constant_id = 2) const uint MIRROR = 0; // not 0 for a ray of reflections
layout(push_constant, scalar) uniform push_block { Rays rays; };
READS(object_params)
READS(camera)
READS(pixel_lights)
READS(placed_positions)
READS(placed_normals)
READS(triangles)
READS(placed_bounds)
READS(hits)
READS(sky_cells)
UPDATES(pixel_lit)
UPDATES(cut_short)
#include "geometry/blend.glsl"
#include "lighting/way.glsl"
#include "geometry/exact.glsl"
#include "geometry/turn.glsl"
#include "geometry/random.glsl"
#include "lighting/pixel_light.glsl"
#include "view/object.glsl"
#include "view/mirror_ray.glsl"

void main() {
    uint k = invocation();
    if (k >= rays.count) return;
    uint pixel = rays.first + k;
    Hit hit = hits[pixel];
    bool shown = hit.face < UNFINISHED;
    uint face = shown ? hit.face : 0;
    uint object = object_of(face);
    uvec3 corner = triangles[face];
    precise vec3 weight = CORNER_WEIGHTS(hit);
    precise vec3 place = BLEND_AT(weight, placed_positions, corner);
    precise vec3 normal = BLEND_AT(weight, placed_normals, corner);
    Light light = pixel_lights[rays.light];
    bool reflects = object_params[object].reflection != REFLECTION_NONE, asked, freely = false;
    if (MIRROR != 0) {
        Seen seen = seen_at(hit, face);
        bool ggx = object_params[object].reflection == REFLECTION_GGX;
        light = mirror_ray(light, pixel, seen, drawn_shape(light, pixel, object), ggx);
        asked = shown && reflects && traced(seen, light);
        freely = shown && reflects && !asked;
    } else {
        // Opaque objects are lit here by all lights; other objects only reflect them, but not the rays that light.
        light = pixel_light(rays.light, pixel, normal);
        bool opaque = object_params[object].opaque == OPAQUE_BY_PIXEL;
        asked = shown && (opaque || (reflects && light.kind != LIGHT_SKY_RAY));
    }
    bool others = OTHERS != 0 && object_params[object].opaque == OPAQUE_NOT;
    uint met = occlusion(way(light, object, face, place, asked, others));
    if (met == UNFINISHED) cut_short[0] = 1;
    bool free = freely || met == FREE;

    // The first light of a word clears it.
    uint word = pixel * camera[0].shadow_words + light.shadow / 32, bit = light.shadow % 32;
    uint before = bit == 0 ? 0 : pixel_lit[word];
    pixel_lit[word] = before | (free ? 1u << bit : 0u);
}
