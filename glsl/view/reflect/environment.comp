#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "lighting/fresnel.glsl"

// The environment's reflection: a sum of its image along rays, each divided by the density of all in its direction
// (Veach and Guibas 1995).
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint GGX = 0;    // number of its lobes; 0: Phong's
layout(constant_id = 2) const uint COUNT = 1;  // rays drawn from the lobe
layout(constant_id = 3) const uint BRIGHT = 0; // rays drawn from where the environment is bright, after those
layout(push_constant, scalar) uniform push_block { uint object; }; // whose pixels this dispatch shades
READS(object_params)
READS(camera)
READS(pixel_lights)
READS(pixel_lit)
READS(sky)
READS(sky_cells)
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

// The density of rays to where the environment is bright, by solid angle.
float bright_density(vec3 way) {
    float whole = abs(way.x) + abs(way.y) + abs(way.z), part = length(way) / whole;
    return sky_cells[cell_of(way)].density * part * part * part;
}

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face < object_params[object].first_face || hit.face >= object_params[object].first_face + object_params[object].faces) return;
    Seen s = seen_at(hit, hit.face);
    float along = dot(s.normal, s.eye), shape = object_params[object].roughness;
    // The eye is taken to be above the surface, as its facets are.
    vec3 upper = s.eye - 2.0 * min(along, 0.0) * s.normal, mirror = 2.0 * along * s.normal - s.eye;
    vec3 sum = vec3(0);
    for (uint k = 0; k < COUNT + BRIGHT; ++k) {
        Light ray = pixel_lights[camera[0].lights + k];
        float drawn = GGX == 2 ? drawn_shape(ray, pixel, object) : shape;
        vec3 direction = mirror_ray(ray, pixel, s, drawn, GGX != 0).place;
        float cosine = max(dot(s.normal, direction), 0.0), met = cosine;
        if (GGX != 0) met = sqrt(max(0.5 + 0.5 * dot(upper, direction), 0.0));
        vec2 lobe = GGX != 0 ? facet_lobe(shape, s.normal, abs(along), upper, direction)
                             : phong_lobe(shape, mirror, direction);
        if (GGX == 2) {
            vec2 second = facet_lobe(object_params[object].second_roughness, s.normal, abs(along), upper, direction);
            lobe = mix(lobe, second, object_params[object].second_share);
        }
        float density = float(COUNT) * lobe.y;
        if (BRIGHT != 0) density += float(BRIGHT) * bright_density(direction);
        float weight = cosine * lobe.x / max(density, 1e-30) * reaches(ray, pixel);
        sum += sky_toward(direction) * weight * (1.0 - transmittance(object_params[object].eta, met));
    }
    radiance[pixel] += camera[0].radiance * sum;
}
