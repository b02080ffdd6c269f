#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "lighting/fresnel.glsl"

// The reflections of lights that have a position or a direction, if they reach the point.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint GGX = 0; // number of its lobes; 0: Phong's
layout(push_constant, scalar) uniform push_block { uint object; }; // whose pixels this dispatch shades
READS(object_params)
READS(camera)
READS(pixel_lights)
READS(pixel_lit)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(hits)
UPDATES(radiance)
#define LIT(word) pixel_lit[word]
#define LIT_WORDS camera[0].shadow_words
#include "lighting/arrival.glsl"
#include "view/lobe.glsl"
#include "view/surface.glsl"
#include "geometry/sight.glsl"
#include "geometry/exact.glsl"
#include "geometry/turn.glsl"
#include "geometry/random.glsl"
#include "lighting/pixel_light.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face < object_params[object].first_face || hit.face >= object_params[object].first_face + object_params[object].faces) return;
    Surface s = surface(hit);
    float signed_seen = dot(s.normal, s.toward), seen = abs(signed_seen), alpha = object_params[object].roughness;
    vec3 sum = vec3(0);
    for (uint i = 0; i < camera[0].lights; ++i) {
        Light light = pixel_light(i, pixel, s.normal);
        vec3 toward;
        float falloff = arrival(light, s.point, toward) * reaches(light, pixel);
        float cosine = max(dot(s.normal, toward), 0.0), lobe, met;
        if (GGX != 0) {
            vec3 facet = unit(s.toward + toward);
            met = dot(s.toward, facet);
            lobe = facet_density(alpha, s.normal, facet) * masking(alpha, seen, cosine);
            if (GGX == 2) {
                float other = object_params[object].second_roughness;
                float second = facet_density(other, s.normal, facet) * masking(other, seen, cosine);
                lobe = mix(lobe, second, object_params[object].second_share);
            }
        } else {
            vec3 mirror = 2.0 * signed_seen * s.normal - s.toward;
            met = cosine;
            lobe = (alpha + 2.0) / (2.0 * 3.14159265358979) * power(dot(mirror, toward), uint(alpha));
        }
        float counts = light.kind == LIGHT_SKY_RAY || cosine <= 0.0 ? 0.0 : falloff * cosine * lobe;
        sum += light.color * counts * (1.0 - transmittance(object_params[object].eta, met));
    }
    radiance[pixel] += camera[0].radiance * sum;
}
