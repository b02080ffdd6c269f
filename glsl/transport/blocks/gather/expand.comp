#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A block's distant emitters, expanded about its centre: value, gradient and second derivatives, to total order 2.
layout(constant_id = 0) const uint CHANNELS = 7;
layout(constant_id = 1) const uint ORDER = 2;
layout(constant_id = 2) const uint ESTIMATE = 0;
layout(constant_id = 3) const uint ALONE = 1;
layout(constant_id = 4) const uint ANY_LIGHT = 0;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(moments)
READS(second_moments)
READS(spheres)
READS(runs)
READS(entries)
UPDATES(expansions)
UPDATES(near_channels)
#include "dipole/derivatives.glsl"
#include "transport/blocks/cluster_moments.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"
#include "transport/blocks/expand.glsl"

Dipole dipoles[3];

Expansion sum_of(uint block, uint first, uint last) {
    vec3 center = spheres[block].center;
    vec3 value = vec3(0), error = vec3(0), bend = vec3(0);
    vec3 gradient[3] = vec3[3](vec3(0), vec3(0), vec3(0));
    vec3 diagonal[3] = vec3[3](vec3(0), vec3(0), vec3(0)), mixed[3] = vec3[3](vec3(0), vec3(0), vec3(0));
    for (uint k = first; k < last; ++k) {
        // Lists that serve any light contain dark emitters.
        if (ANY_LIGHT != 0 && moments[entries[k]].weight == 0.0) continue;
        ClusterMoments m = cluster_moments(entries[k]);
        vec3 d = center - m.center;
        float d2 = dot(d, d);
        vec3 cross_terms = d.yzx * d.zxy;
        float tau = ORDER == 2 ? m.diagonal.x + m.diagonal.y + m.diagonal.z : 0.0;
        float along = ORDER == 2 ? dot(m.diagonal, d * d) + 2.0 * dot(m.mixed, cross_terms) : 0.0;
        EACH_CHANNEL({
            vec3 p = m.weight * profile_derivatives(dipoles[c], d2);
            value[c] += p.x + 0.5 * (p.y * tau + p.z * along);
            gradient[c] += p.y * d;
            diagonal[c] += p.y + p.z * d * d;
            mixed[c] += p.z * cross_terms;
            if (ESTIMATE != 0) {
                float unit = unit_chi(p, d2, dipoles[c].z2.x);
                float trace = m.diagonal.x + m.diagonal.y + m.diagonal.z;
                error[c] += missed_moments(ORDER, dipoles[c].sigma, p, unit, trace);
                bend[c] += missed_bend(p, unit, spheres[block].radius);
            }
        })
    }
    return Expansion(value,
        vec3(gradient[0].x, gradient[1].x, gradient[2].x), vec3(gradient[0].y, gradient[1].y, gradient[2].y),
        vec3(gradient[0].z, gradient[1].z, gradient[2].z), vec3(diagonal[0].x, diagonal[1].x, diagonal[2].x),
        vec3(diagonal[0].y, diagonal[1].y, diagonal[2].y), vec3(diagonal[0].z, diagonal[1].z, diagonal[2].z),
        vec3(mixed[0].x, mixed[1].x, mixed[2].x), vec3(mixed[0].y, mixed[1].y, mixed[2].y),
        vec3(mixed[0].z, mixed[1].z, mixed[2].z), error, bend);
}

void main() {
    uint i = item();
    if (i >= range.count) return;
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    uint block = range.first + i;
    uint near = (runs[i].area > 0 ? CHANNELS : 0) | (runs[i].edge > 0 ? CHANNELS << 3 : 0);
    Expansion sum = sum_of_runs(block, runs[i].first, runs[i].first + runs[i].expanded);
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    if (ALONE == 0) {
        // Other groups' channels are kept.
        Expansion old = expansions[block];
        sum = Expansion(only_group(sum.value, old.value),
            only_group(sum.x, old.x), only_group(sum.y, old.y), only_group(sum.z, old.z),
            only_group(sum.xx, old.xx), only_group(sum.yy, old.yy), only_group(sum.zz, old.zz),
            only_group(sum.yz, old.yz), only_group(sum.zx, old.zx), only_group(sum.xy, old.xy),
            only_group(sum.error, old.error), only_group(sum.bend, old.bend));
        near |= near_channels[block] & ~(CHANNELS << 3 | CHANNELS);
    }
    near_channels[block] = near;
    expansions[block] = sum;
}
