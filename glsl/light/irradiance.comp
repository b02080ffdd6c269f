#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "light/fresnel.glsl"

// E of equation 5 at a face's centroid: every light's cosine times Fresnel transmittance, where it is not shadowed, and
// the environment by its harmonics.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint SKY = 0;
READS(frame)
READS(lights)
READS(leaves)
READS(clusters)
READS(lit)
READS(harmonics)
WRITES(irradiance)
#include "light/harmonics.glsl"

// The share of a light's intensity in the unit direction `away` from it. 1 - cos is taken from the sine, which is exact
// for narrow cones, too.
float emission(Light light, vec3 away) {
    float c = dot(light.axis, away);
    vec3 s = cross(light.axis, away);
    float t = clamp((light.outer - dot(s, s) / (1.0 + max(c, 0.0))) / (light.outer - light.inner), 0.0, 1.0);
    if (light.kind == 2) return c > 0.0 ? t * t * (3.0 - 2.0 * t) : 0.0;
    if (light.kind == 3) return max(c, 0.0);
    return light.kind == 4 ? abs(c) : 1.0;
}

void main() {
    uint face = invocation();
    if (face >= frame[0].faces) return;
    Cluster leaf = clusters[leaves[face]];
    vec3 normal = leaf.area > 0.0 ? leaf.normal / leaf.area : vec3(0);
    bool both = frame[0].two_sided != 0;
    vec3 sum = vec3(0);

    // What arrives from the environment in front and behind, and how much of it along the rays that are free.
    vec3 all_front = vec3(0), free_front = vec3(0), all_back = vec3(0), free_back = vec3(0);
    for (uint i = 0; i < frame[0].lights; ++i) {
        Light light = lights[i];
        vec3 toward = light.place;
        float falloff = 1.0;
        if (light.kind != 0 && light.kind != 5) {
            toward -= leaf.center;
            float d2 = max(dot(toward, toward), 1e-30);
            toward /= sqrt(d2);
            falloff = emission(light, -toward) / d2;
        }
        float cosine = dot(normal, toward);
        float counts = both ? abs(cosine) : max(cosine, 0.0);
        float lets = 1.0;
        if (SHADOWS != 0) {
            if (light.shadow != NONE) {
                uint word = lit[face * frame[0].shadow_words + light.shadow / 32];
                lets = float(word >> (light.shadow % 32) & 1u);
            }
        }
        vec3 enters = counts * transmittance(frame[0].eta, counts);
        if (light.kind != 5) sum += light.color * (falloff * lets) * enters;
        if (SKY != 0) {
            if (light.kind == 5) {
                vec3 weight = sky_radiance(toward) * enters;
                all_front += cosine > 0.0 ? weight : vec3(0);
                free_front += cosine > 0.0 ? lets * weight : vec3(0);
                all_back += cosine > 0.0 ? vec3(0) : weight;
                free_back += cosine > 0.0 ? vec3(0) : lets * weight;
            }
        }
    }
    if (SKY != 0) {
        // Where no ray is blocked the share is 1 to the last bit.
        bvec3 open_front = equal(free_front, all_front), open_back = equal(free_back, all_back);
        vec3 least = vec3(1e-30);
        sum += sky_irradiance(normal) * mix(free_front / max(all_front, least), vec3(1), open_front);
        if (both) sum += sky_irradiance(-normal) * mix(free_back / max(all_back, least), vec3(1), open_back);
    }
    irradiance[face] = sum;
}
