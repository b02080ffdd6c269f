#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Radiance of opaque objects: albedo times the irradiance at the very point that a pixel shows, over pi.
layout(constant_id = 0) const uint OBJECTS = 1;
layout(constant_id = 1) const uint SHADOWS = 0;
layout(constant_id = 2) const uint SKY = 0;
READS(object_params)
READS(camera)
READS(pixel_lights)
READS(pixel_lit)
READS(harmonics)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(hits)
UPDATES(radiance)
#include "geometry/blend.glsl"
#include "geometry/sight.glsl"
#include "geometry/exact.glsl"
#include "geometry/turn.glsl"
#include "geometry/random.glsl"
#include "lighting/pixel_light.glsl"

// The lights as this pixel sees them.
uint pixel;
vec3 blended_normal;
#define LIT(word) pixel_lit[word]
#define LIT_WORDS camera[0].shadow_words
#define LIGHTS camera[0].lights
#define LIGHT_AT(i) pixel_light(i, pixel, blended_normal)
#define SKY_WEIGHT(cosine) 1.0
#include "lighting/entering.glsl"
#include "view/object.glsl"

void main() {
    pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face >= UNFINISHED) return;
    uint object = object_of(hit.face);
    if (object_params[object].opaque != OPAQUE_BY_PIXEL) return;
    uvec3 corner = triangles[hit.face];
    precise vec3 weight = CORNER_WEIGHTS(hit);
    vec3 point = BLEND_AT(weight, placed_positions, corner);
    precise vec3 normal = BLEND_AT(weight, placed_normals, corner);
    blended_normal = normal;
    normal /= sqrt(max(dot(normal, normal), 1e-30));
    vec3 arrives = entering(object, pixel, point, normal);
    vec3 eye = camera[0].origin - point;
    float cosine = abs(dot(normal, eye)) / sqrt(max(dot(eye, eye), 1e-30));
    cosine = facet_cosine(cosine, object_params[object].facet_tilt);
    vec3 leaves = transmittance(object_params[object].eta, cosine) * object_params[object].exit;
    radiance[pixel] = leaves * object_params[object].albedo * arrives * (camera[0].radiance / 3.14159265358979);
}
