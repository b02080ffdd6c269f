#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "layers/beneath.glsl"
#include "layers/segment.glsl"

// Light scattered once beneath each visible point: in closed form from sample to sample, and to each interface between
// them. One loop goes over all lights and, for each, over the parts of the ray.

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

    vec3 sum = vec3(0), dimmed = vec3(0), start = vec3(0), tau = vec3(0), arrived_before = vec3(0);
    float cosine_before = 0.0, done = 0.0; // how much of the step has been walked
    // Depths of the interfaces at the step's ends, and between.
    vec4 before[MOST_MAPS], after[MOST_MAPS], here[MOST_MAPS];
    uint beam = first_beam, now = 0;       // the layer
    int step = -1;                         // -1: nothing has been looked at for this light
    bool next = true;
    while (beam < last_beam) {
        // Goes to the next step; the first one has no length, at the surface.
        bool fresh = next && step < 0;
        step += int(next);
        float to = pace * float(step), from = fresh ? to : pace * float(step - 1);
        Texels there;
        if (MAPPED != MAPPED_NOT) there = texels_at(own, m, -to * m.eye);
        uint last = 0;
        for (uint map = 0; map < MAPS; ++map) {
            vec4 depths_there = depths_of(own, there, map);
            if (MAPPED != MAPPED_NOT) {
                before[map] = fresh ? depths_there : next ? after[map] : before[map];
                after[map] = depths_there;
            }
            here[map] = depths_there;
            last += above(depths_there, m.slope * to);
        }
        if (fresh) {
            now = last;
            dimmed = vec3(0);
        }
        done = next ? 0.0 : done;

        // Goes as far as the next interface on the way, or the step's end.
        uint target = now < last ? now : now - 1;
        float a = 0.0, b = 0.0; // its depths at the step's ends
        for (uint map = 0; map < MAPS; ++map) {
            for (uint k = 0; k < MAP_LAYERS; ++k) {
                bool its = MAP_LAYERS * map + k == target;
                if (MAPPED != MAPPED_NOT) a = its ? before[map][k] : a;
                b = its ? here[map][k] : b;
            }
        }
        a = m.slope * from - (MAPPED != MAPPED_NOT ? a : b);
        b = m.slope * to - b;
        next = now == last;
        float share = next ? 1.0 : max(clamp(a / (a - b), 0.0, 1.0), done);
        float t = mix(from, to, share), walked = (share - done) * (to - from);
        if (MAPPED != MAPPED_NOT) {
            for (uint map = 0; map < MAPS; ++map) here[map] = mix(before[map], after[map], share);
        }

        // The light that arrives there, and the light scattered between the last place and this one.
        Layer layer = layer_media[own.first_layer + min(now, own.layers - 1)];
        Light light = layer_lights[beam];
        Lit lights = lit_at(own, m, object, light, hit.face, t, here);
        dimmed += layer.sigma_t * walked;
        vec3 tau_here = dimmed + lights.dimmed, end = exp(-tau_here);
        vec2 phases = phase(layer.g, vec2(cosine_before, lights.cosine));
        vec3 scattered = segment(arrived_before * phases.x, lights.arrives * phases.y, start, end, tau_here - tau);
        if (!fresh && now < own.layers) sum += light.color * layer.sigma_s * walked * scattered;

        // Moves on.
        arrived_before = lights.arrives;
        cosine_before = lights.cosine;
        start = end;
        tau = tau_here;
        now = next ? now : now < last ? now + 1 : now - 1;
        done = share;
        // An interface at the ray's end is its end, too.
        bool over = step == int(own.samples) && (next || done > 0.999999);
        beam += uint(over);
        step = over ? -1 : step;
        next = next || over;
    }
    shine(pixel, object, m, sum);
}
