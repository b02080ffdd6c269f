#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "layers/beneath.glsl"

// Light scattered once beneath each visible point, by the left rule of algorithm 1, both ends included. A sample at an
// interface counts as above it, whatever the rounding.

void main() {
    uint pixel = first_pixel + invocation();
    if (pixel >= last_pixel) return;
    Hit hit = hits[pixel];
    Layering own = layerings[number];
    uint object = own.object;
    if (hit.face < object_params[object].first_face || hit.face >= object_params[object].first_face + object_params[object].faces) return;
    March m = march(own, hit);
    if (m.reach <= 0.0) return;
    float pace = m.reach / float(own.samples);

    vec3 sum = vec3(0), dimmed = vec3(0);
    uint beam = first_beam, step = 0;
    while (beam < last_beam) {
        float t = pace * float(step);
        Texels there;
        if (MAPPED != MAPPED_NOT) there = texels_at(own, m, -t * m.eye);
        vec4 here[MOST_MAPS];
        uint now = 0;
        for (uint map = 0; map < MAPS; ++map) {
            here[map] = depths_of(own, there, map);
            now += above(here[map], ABOVE_INTERFACE * m.slope * t);
        }
        Layer layer = layer_media[own.first_layer + min(now, own.layers - 1)];
        Light light = layer_lights[beam];
        Lit lights = lit_at(own, m, object, light, hit.face, t, here);
        vec3 scattered = layer.sigma_s * lights.arrives * exp(-dimmed - lights.dimmed) *
                         phase(layer.g, vec2(lights.cosine)).x;
        if (now < own.layers) sum += light.color * pace * scattered;
        dimmed += layer.sigma_t * pace;

        bool over = step == own.samples;
        step = over ? 0 : step + 1;
        dimmed = over ? vec3(0) : dimmed;
        beam += uint(over);
    }
    shine(pixel, object, m, sum);
}
