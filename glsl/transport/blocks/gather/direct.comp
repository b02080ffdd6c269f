#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// Emitters too near to be expanded, each at every receiver of the block. One invocation a receiver; as many emitters
// are loaded at once as invocations share a block, one each, and shuffled.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
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

void main() {
    Dipole dipoles[3] = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint place = group * gl_WorkGroupSize.x + lane();
    Receiver self = receiver_at(place);
    uint width = sharing();
    uint mine = SUBGROUP_LANE % width, base = SUBGROUP_LANE - mine;
    Runs run = runs[self.run];
    uint first = run.first + run.expanded, count = run.direct;
    vec3 sum = vec3(0), error = vec3(0);
    for (uint at = 0; at < count; at += width) {
        ClusterMoments load = cluster_moments(entries[first + min(at + mine, count - 1)]);
        uint last = min(width, count - at);
        for (uint k = 0; k < last; ++k) {
            uint from = base + k;
            float weight = shuffled(load.weight, from);
            // Lists that serve any light contain dark emitters.
            if (ANY_LIGHT != 0 && weight == 0.0) continue;
            vec3 center = shuffled(load.center, from);
            vec3 diagonal = shuffled(load.diagonal, from), mixed = shuffled(load.mixed, from);
            vec3 d = self.x - center;
            float d2 = dot(d, d);
            float half_tau = ORDER == 2 ? 0.5 * (diagonal.x + diagonal.y + diagonal.z) : 0.0;
            float half_along = ORDER == 2 ? 0.5 * dot(diagonal, d * d) + dot(mixed, d.yzx * d.zxy) : 0.0;
            EACH_CHANNEL({
                sum[c] += weight * link_value(dipoles[c], d2, half_tau, half_along);
                if (ESTIMATE != 0) {
                    vec3 p = weight * profile_derivatives(dipoles[c], d2);
                    float unit = unit_chi(p, d2, dipoles[c].z2.x);
                    error[c] += missed_moments(ORDER, dipoles[c].sigma, p, unit, diagonal.x + diagonal.y + diagonal.z);
                }
            })
        }
    }
    if (!self.present) return;
    received[self.face] = only_group(sum, received[self.face]);
    if (ESTIMATE != 0) estimate[self.face] = only_group(error, estimate[self.face]);
}
