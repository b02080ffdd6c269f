#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "layers/beneath.glsl"

// Light scattered once beneath each visible point: from sample to sample, and to each interface between them, in closed
// form. One loop for all lights, a part of the ray at a time.

// The integral over s from 0 to 1 of (a + (b - a) s) exp(-(from + (to - from) s)), where `start` = exp(-from), `end` = exp(-to).
vec3 segment(vec3 a, vec3 b, vec3 start, vec3 end, vec3 d) {
    vec3 e0 = 1.0 - d / 2.0 * (1.0 - d / 3.0 * (1.0 - d / 4.0 * (1.0 - d / 5.0 * (1.0 - d / 6.0))));
    vec3 e1 = 0.5 - d * (1.0 / 3.0 - d / 2.0 * (0.25 - d / 3.0 * (0.2 - d / 4.0 * (1.0 / 6.0 - d / 35.0))));
    bvec3 small = lessThan(abs(d), vec3(0.3));
    vec3 safe = mix(d, vec3(1), small);
    vec3 first = mix((start - end) / safe, start * e0, small);
    vec3 second = mix((start - end - safe * end) / safe / safe, start * e1, small);
    return a * first + (b - a) * second;
}

void main() {
    uint pixel = first_pixel + invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    Layering own = layerings[number];
    uint object = own.object;
    if (hit.face < frame[object].first_face || hit.face >= frame[object].first_face + frame[object].faces) return;
    March m = march(own, hit);
    if (m.reach <= 0.0) return;
    float pace = m.reach / float(own.samples);

    vec3 sum = vec3(0), dimmed = vec3(0), start = vec3(0), tau = vec3(0), arrived_before = vec3(0);
    float cosine_before = 0.0, done = 0.0; // how much of the step has been walked
    vec4 before[4], after[4];              // depths of the interfaces at the step's ends
    uint beam = first_beam, now = 0;       // the layer
    int step = -1;                         // -1: nothing has been looked at for this light
    bool next = true;
    while (beam < last_beam) {
        // The next step, at first one of no length at the surface.
        bool fresh = next && step < 0;
        step += int(next);
        float to = pace * float(step), from = fresh ? to : pace * float(step - 1);
        Texels there;
        if (MAPPED != 0) there = texels_at(own, m, -to * m.eye);
        uint last = 0;
        for (uint map = 0; map < MAPS; ++map) {
            vec4 depths_there = depths_of(own, there, map);
            before[map] = fresh ? depths_there : next ? after[map] : before[map];
            after[map] = depths_there;
            last += above(depths_there, m.slope * to);
        }
        if (fresh) {
            now = last;
            dimmed = vec3(0);
        }
        done = next ? 0.0 : done;

        // As far as the next interface on the way, or the step's end.
        uint target = now < last ? now : now - 1;
        float a = 0.0, b = 1.0;
        for (uint map = 0; map < MAPS; ++map) {
            for (uint k = 0; k < 4; ++k) {
                bool its = 4 * map + k == target;
                a = its ? m.slope * from - before[map][k] : a;
                b = its ? m.slope * to - after[map][k] : b;
            }
        }
        next = now == last;
        float share = next ? 1.0 : max(clamp(a / (a - b), 0.0, 1.0), done);
        float t = mix(from, to, share), walked = (share - done) * (to - from);
        vec4 here[4];
        for (uint map = 0; map < MAPS; ++map) here[map] = mix(before[map], after[map], share);

        // The light there, and between the last place and this.
        Layer layer = beneath[own.first_layer + min(now, own.layers - 1)];
        Light light = beams[beam];
        Lit lights = lit_at(own, m, object, light, hit.face, t, here);
        dimmed += layer.sigma_t * walked;
        vec3 tau_here = dimmed + lights.dimmed, end = exp(-tau_here);
        vec3 scattered = segment(arrived_before * phase(layer.g, cosine_before),
                                 lights.arrives * phase(layer.g, lights.cosine), start, end, tau_here - tau);
        if (!fresh && now < own.layers) sum += light.color * layer.sigma_s * walked * scattered;

        // On.
        arrived_before = lights.arrives;
        cosine_before = lights.cosine;
        start = end;
        tau = tau_here;
        now = next ? now : now < last ? now + 1 : now - 1;
        done = share;
        bool over = next && step == int(own.samples);
        beam += uint(over);
        step = over ? -1 : step;
    }
    shine(pixel, object, m, sum);
}
