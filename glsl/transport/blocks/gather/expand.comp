#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A block's distant emitters, expanded about its centre: value, gradient and second derivatives, to total order 2. Each
// run of EXPAND_RUN emitters is summed by itself, then these sums are, in their order: so runs may be summed at once.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = LANES_ID) const uint LANES = 1; // invocations that share a block: 1, or all those of the group
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
#include "dipole/derivatives.glsl"
#include "transport/blocks/cluster_moments.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"

const uint EXPAND_RUN = 8; // emitters that are summed by themselves
const uint EXPAND_RUNS = 32; // such runs that a group sums at once

Dipole dipoles[3];

// The expansion of one run of emitters.
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

const Expansion NOTHING = Expansion(vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0),
                                    vec3(0), vec3(0), vec3(0));

Expansion plus(Expansion a, Expansion b) {
    return Expansion(a.value + b.value, a.x + b.x, a.y + b.y, a.z + b.z, a.xx + b.xx, a.yy + b.yy, a.zz + b.zz,
        a.yz + b.yz, a.zx + b.zx, a.xy + b.xy, a.error + b.error, a.bend + b.bend);
}

// An expansion's numbers, and one more so that lanes meet in no bank of memory.
const uint NUMBERS = 36, APART = 37;
shared float sums[EXPAND_RUNS * APART];

void put(uint at, vec3 v) {
    sums[at] = v.x;
    sums[at + 1] = v.y;
    sums[at + 2] = v.z;
}
vec3 got(uint at) { return vec3(sums[at], sums[at + 1], sums[at + 2]); }

// The sum of all runs, for the first invocation of the group.
Expansion sum_together(uint block, uint first, uint last) {
    uint self = gl_LocalInvocationIndex;
    float own[2] = float[2](0, 0); // sums of the numbers self and self + LANES: two rounds cover all NUMBERS
    for (uint begin = first; begin < last; begin += EXPAND_RUNS * EXPAND_RUN) {
        uint runs = min((last - begin + EXPAND_RUN - 1) / EXPAND_RUN, EXPAND_RUNS);
        barrier();
        for (uint run = self; run < runs; run += LANES) {
            uint from = begin + run * EXPAND_RUN, at = run * APART;
            Expansion e = sum_of(block, from, min(from + EXPAND_RUN, last));
            put(at, e.value);
            put(at + 3, e.x); put(at + 6, e.y); put(at + 9, e.z);
            put(at + 12, e.xx); put(at + 15, e.yy); put(at + 18, e.zz);
            put(at + 21, e.yz); put(at + 24, e.zx); put(at + 27, e.xy);
            put(at + 30, e.error); put(at + 33, e.bend);
        }
        barrier();
        for (uint k = 0; k < 2; ++k) {
            uint number = self + k * LANES;
            if (number < NUMBERS) for (uint run = 0; run < runs; ++run) own[k] += sums[run * APART + number];
        }
    }
    barrier();
    for (uint k = 0; k < 2; ++k) if (self + k * LANES < NUMBERS) sums[self + k * LANES] = own[k];
    barrier();
    return Expansion(got(0), got(3), got(6), got(9), got(12), got(15), got(18), got(21), got(24), got(27), got(30), got(33));
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint i = LANES == 1 ? group * gl_WorkGroupSize.x + gl_LocalInvocationIndex : group;
    if (i >= range.count) return;
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    uint block = range.first + i;
    uint first = runs[i].first, last = first + runs[i].expanded;
    Expansion sum = NOTHING;
    if (LANES > 1) sum = sum_together(block, first, last);
    else for (uint at = first; at < last; at += EXPAND_RUN) sum = plus(sum, sum_of(block, at, min(at + EXPAND_RUN, last)));
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    if (ALONE == 0) {
        // Other groups' channels are kept.
        Expansion old = expansions[block];
        sum = Expansion(only_group(sum.value, old.value),
            only_group(sum.x, old.x), only_group(sum.y, old.y), only_group(sum.z, old.z),
            only_group(sum.xx, old.xx), only_group(sum.yy, old.yy), only_group(sum.zz, old.zz),
            only_group(sum.yz, old.yz), only_group(sum.zx, old.zx), only_group(sum.xy, old.xy),
            only_group(sum.error, old.error), only_group(sum.bend, old.bend));
    }
    expansions[block] = sum;
}
