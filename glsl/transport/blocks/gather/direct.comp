#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// Sums emitters too near to be expanded, each at every receiver of the block.
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
#include "transport/blocks/direct.glsl"

Dipole dipoles[3];

// Adds an emitter to them, for a receiver at `d` from it. The diagonal is halved.
void add(ClusterMoments m, vec3 d) {
    vec3 squares = d * d;
    float d2 = squares.x + squares.y + squares.z, half_tau = m.diagonal.x + m.diagonal.y + m.diagonal.z;
    float half_along = ORDER == 2 ? dot(m.diagonal, squares) + dot(m.mixed, d.yzx * d.zxy) : 0.0;
    EACH_CHANNEL({
        sum[c] += m.weight * link_value(dipoles[c], d2, ORDER == 2 ? half_tau : 0.0, half_along);
        if (ESTIMATE != 0) {
            vec3 p = m.weight * profile_derivatives(dipoles[c], d2);
            float unit = unit_chi(p, d2, dipoles[c].z2.x);
            error[c] += missed_moments(ORDER, dipoles[c].sigma, p, unit, 2.0 * half_tau);
        }
    })
}

void add_some(vec3 x, uint first, uint at, uint count, uint width) {
    uint mine = SUBGROUP_LANE % width, base = SUBGROUP_LANE - mine;
    ClusterMoments load = cluster_moments(entries[first + min(at + mine, count - 1)]);
    load.diagonal *= 0.5;
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

void main() {
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    Receiver self;
    vec3 all, all_errors;
    if (!sum_of_runs(self, all, all_errors)) return;
    received[self.face] = only_group(all, received[self.face]);
    if (ESTIMATE != 0) estimate[self.face] = only_group(all_errors, estimate[self.face]);
}
