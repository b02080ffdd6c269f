#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// Sums emitters too near to be expanded, each at every receiver of the block. Neighbouring invocations that share a
// block load one emitter each, and shuffle them. Each run of DIRECT_RUN emitters is summed by itself, then these sums
// are, in their order: so runs may be summed at once.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = TEAMS_ID) const uint TEAMS = 1; // invocations that share a receiver: 1, or the group has one block
layout(constant_id = 0) const uint CHANNELS = 7;
layout(constant_id = 1) const uint ORDER = 2;
layout(constant_id = 2) const uint ESTIMATE = 0;
layout(constant_id = 3) const uint ANY_LIGHT = 0;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(moments)
READS(second_moments)
READS(runs)
READS(entries)
UPDATES(received)
UPDATES(estimate)
#include "dipole/derivatives.glsl"
#include "transport/blocks/cluster_moments.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"
#include "transport/blocks/gather/receiver.glsl"

const uint DIRECT_RUN = 16; // emitters that are summed by themselves
const uint DIRECT_RUNS = 8; // such runs that a group sums at once

Dipole dipoles[3];
// The sums of one receiver.
vec3 sum, error;

// Adds an emitter to them, for a receiver at `d` from it.
void add(ClusterMoments m, vec3 d) {
    float d2 = dot(d, d);
    float half_tau = ORDER == 2 ? 0.5 * (m.diagonal.x + m.diagonal.y + m.diagonal.z) : 0.0;
    float half_along = ORDER == 2 ? 0.5 * dot(m.diagonal, d * d) + dot(m.mixed, d.yzx * d.zxy) : 0.0;
    EACH_CHANNEL({
        sum[c] += m.weight * link_value(dipoles[c], d2, half_tau, half_along);
        if (ESTIMATE != 0) {
            vec3 p = m.weight * profile_derivatives(dipoles[c], d2);
            float unit = unit_chi(p, d2, dipoles[c].z2.x);
            error[c] += missed_moments(ORDER, dipoles[c].sigma, p, unit, m.diagonal.x + m.diagonal.y + m.diagonal.z);
        }
    })
}

// Adds as many emitters of the list as are loaded at once, from number `at` on.
void add_some(vec3 x, uint first, uint at, uint count, uint width) {
    uint mine = SUBGROUP_LANE % width, base = SUBGROUP_LANE - mine;
    ClusterMoments load = cluster_moments(entries[first + min(at + mine, count - 1)]);
    uint last = min(width, count - at);
    for (uint k = 0; k < last; ++k) {
        uint from = base + k;
        ClusterMoments m;
        m.weight = shuffled(load.weight, from);
        // Lists that serve any light contain dark emitters.
        if (ANY_LIGHT != 0 && m.weight == 0.0) continue;
        m.center = shuffled(load.center, from);
        m.diagonal = shuffled(load.diagonal, from);
        m.mixed = shuffled(load.mixed, from);
        add(m, x - m.center);
    }
}

shared vec3 sums[DIRECT_RUNS * BLOCK_RECEIVERS], errors[DIRECT_RUNS * BLOCK_RECEIVERS];

void main() {
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint slot = lane() % BLOCK_RECEIVERS, team = lane() / BLOCK_RECEIVERS, width = sharing();
    Receiver self = receiver_at(TEAMS == 1 ? group * gl_WorkGroupSize.x + lane() : group * BLOCK_RECEIVERS + slot);
    Runs run = runs[self.run];
    uint first = run.first + run.expanded, count = run.direct;
    vec3 all = vec3(0), all_errors = vec3(0);
    sum = vec3(0);
    error = vec3(0);
    if (TEAMS == 1) {
        for (uint at = 0; at < count; at += width) {
            add_some(self.x, first, at, count, width);
            if ((at + width) % DIRECT_RUN == 0 || at + width >= count) {
                all += sum;
                all_errors += error;
                sum = vec3(0);
                error = vec3(0);
            }
        }
    } else {
        // The group has one block, so that all its invocations reach each barrier.
        for (uint begin = 0; begin < count; begin += DIRECT_RUNS * DIRECT_RUN) {
            for (uint k = team; k < DIRECT_RUNS; k += TEAMS) {
                uint from = begin + k * DIRECT_RUN, to = min(from + DIRECT_RUN, count);
                sum = vec3(0);
                error = vec3(0);
                for (uint at = from; at < to; at += width) add_some(self.x, first, at, to, width);
                sums[k * BLOCK_RECEIVERS + slot] = sum;
                if (ESTIMATE != 0) errors[k * BLOCK_RECEIVERS + slot] = error;
            }
            barrier();
            for (uint k = 0; k < DIRECT_RUNS && begin + k * DIRECT_RUN < count; ++k) {
                all += sums[k * BLOCK_RECEIVERS + slot];
                if (ESTIMATE != 0) all_errors += errors[k * BLOCK_RECEIVERS + slot];
            }
            barrier();
        }
        if (team > 0) return;
    }
    if (!self.present) return;
    received[self.face] = only_group(all, received[self.face]);
    if (ESTIMATE != 0) estimate[self.face] = only_group(all_errors, estimate[self.face]);
}
