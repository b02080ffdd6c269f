#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "lighting/fresnel.glsl"

// The environment's reflection: the mean of its image along rays drawn from the lobe, each divided by its density.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint GGX = 0;
layout(constant_id = 2) const uint COUNT = 1;
layout(push_constant, scalar) uniform push_block { uint object; }; // whose pixels this dispatch shades
READS(object_params)
READS(camera)
READS(pixel_lights)
READS(pixel_lit)
READS(sky)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(hits)
UPDATES(radiance)
#define LIT(word) pixel_lit[word]
#define LIT_WORDS camera[0].shadow_words
#include "lighting/arrival.glsl"
#include "lighting/sky.glsl"
#include "geometry/blend.glsl"
#include "geometry/sight.glsl"
#include "geometry/plane.glsl"
#include "geometry/exact.glsl"
#include "geometry/turn.glsl"
#include "geometry/random.glsl"
#include "lighting/pixel_light.glsl"
#include "view/mirror_ray.glsl"
#include "view/lobe.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face < object_params[object].first_face || hit.face >= object_params[object].first_face + object_params[object].faces) return;
    Seen s = seen_at(hit, hit.face);
    float signed_seen = dot(s.normal, s.eye), seen = abs(signed_seen), shape = object_params[object].roughness;
    // The eye is taken to be above the surface, as its facets are.
    vec3 upper = s.eye - 2.0 * min(signed_seen, 0.0) * s.normal, mirror = 2.0 * signed_seen * s.normal - s.eye;
    vec3 sum = vec3(0);
    for (uint k = 0; k < COUNT; ++k) {
        Light ray = pixel_lights[camera[0].lights + k];
        vec3 direction = mirror_ray(ray, pixel, s, shape, GGX != 0).place;
        float cosine = max(dot(s.normal, direction), 0.0), met = cosine, weight;
        if (GGX != 0) {
            met = sqrt(max(0.5 + 0.5 * dot(upper, direction), 0.0));
            weight = facet_weight(shape, seen, cosine);
        } else {
            weight = cosine * phong_weight(shape, mirror, direction);
        }
        float lets = reaches(ray, pixel);
        sum += sky_toward(direction) * (weight * lets) * (1.0 - transmittance(object_params[object].eta, met));
    }
    radiance[pixel] += camera[0].radiance / float(COUNT) * sum;
}
