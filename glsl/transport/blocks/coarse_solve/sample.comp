#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The coarse solution at a few receivers: one half evenly among the triangles, one half by the light.
layout(constant_id = 0) const uint CHANNELS = 7;
READS(object_params)
READS(topology)
READS(leaves)
READS(clusters)
READS(moments)
READS(second_moments)
WRITES(samples)
#include "dipole/near.glsl"
#include "dipole/derivatives.glsl"
#include "transport/blocks/channels.glsl"

const uint HALF = COARSE_SAMPLES / 2;

// The triangle at this share of the light: decisions, so exact.
uint by_light(uint k) {
    precise float target = moments[0].weight * ((float(k) + 0.5) * (1.0 / float(HALF)));
    uint node = 0;
    while (topology[node].face == NONE) {
        uint left = node + 1, right = topology[left].skip;
        float before = moments[left].weight;
        bool goes_left = target < before || !(moments[right].weight > 0.0);
        precise float rest = target - before;
        if (!goes_left) target = rest;
        node = goes_left ? left : right;
    }
    return node;
}

void main() {
    uint k = invocation();
    if (k >= COARSE_SAMPLES) return;
    uint even = min(uint((float(k) + 0.5) * (1.0 / float(HALF)) * float(object_params[0].faces)), object_params[0].faces - 1);
    uint leaf = k < HALF ? leaves[even] : by_light(k - HALF);
    vec3 x = clusters[leaf].center;
    float whole = moments[0].weight;
    float light = whole > 0.0 ? moments[leaf].weight / whole : 0.0;

    vec3 plane = 6.2831853 * object_params[0].strength * object_params[0].tint *
        (exp(-object_params[0].sigma * object_params[0].z_real) + exp(-object_params[0].sigma * object_params[0].z_virtual));
    Dipole dipoles[3] = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    vec3 sum = vec3(0);
    uint node = 0, end = object_params[0].nodes;
    while (node < end) {
        Moment m = moments[node];
        SecondMoments s = second_moments[node];
        uint skip = topology[node].skip;
        bool lit = m.weight > 0.0, leaf_here = skip == node + 1;
        float d2 = distance2(x, m.center);
        precise float reach2 = s.coarse * s.coarse;
        bool far = d2 >= reach2;
        if (lit && (far || leaf_here)) {
            vec3 d = x - m.center;
            float tau = s.diagonal.x + s.diagonal.y + s.diagonal.z;
            float along = dot(s.diagonal, d * d) + 2.0 * dot(s.mixed, d.yzx * d.zxy);
            EACH_CHANNEL({
                vec3 p = profile_derivatives(dipoles[c], d2);
                float value = m.weight * (far ? p.x + 0.5 * (p.y * tau + p.z * along) : p.x);
                // No triangle gives more than the whole plane would.
                float area = leaf_here ? max(clusters[node].area, 1e-30) : 1.0;
                sum[c] += far ? value : min(value, plane[c] * m.weight / area);
            })
        }
        node = lit && !far && !leaf_here ? node + 1 : skip;
    }
    float chance = 0.5 / float(object_params[0].faces) + 0.5 * light;
    float area = clusters[leaf].area, mean = clusters[0].area / float(object_params[0].faces);
    // One factor after the other, so that nothing leaves the range of f32.
    float enters = area > 0.0 && whole > 0.0 ? light * (clusters[0].area / area) : 0.0;
    float share = mean > 0.0 ? area / mean : 0.0;
    samples[k] = Sample(topology[leaf].face, chance, max(sum, vec3(0)),
                        enters * enters * (share / (chance * float(object_params[0].faces))));
}
