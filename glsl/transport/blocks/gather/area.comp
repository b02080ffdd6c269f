#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds near triangles by 6 area points, each at every receiver of the block.
layout(constant_id = 0) const uint CHANNELS = 7;
layout(constant_id = 1) const uint ESTIMATE = 0;
layout(constant_id = 2) const uint ANY_LIGHT = 0;
layout(push_constant, scalar) uniform push_block { Range range; Range part; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(topology)
READS(triangles)
READS(positions)
READS(moments)
READS(second_moments)
READS(runs)
READS(entries)
READS(near)
READS(near_groups)
UPDATES(area_received)
UPDATES(estimate)
#include "dipole/derivatives.glsl"
#include "transport/blocks/cluster_moments.glsl"
#include "dipole/form_factor/points.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"
#include "transport/blocks/gather/receiver.glsl"
const bool ERRORS = ESTIMATE != 0;
#include "transport/blocks/gather/near.glsl"

Dipole dipoles[3];
Receiver self;
uint first;

void add(uint k) {
    uint node = entries[first + k];
    // Lists that serve any light contain dark emitters.
    if (ANY_LIGHT != 0 && moments[node].weight == 0.0) return;
    uvec3 corner = triangles[topology[node].face];
    vec3 a = self.x - positions[corner.x], b = self.x - positions[corner.y], c = self.x - positions[corner.z];
    float weight = moments[node].weight;
    for (uint j = 0; j < 6; ++j) {
        vec4 point = RULE[RULE_FIRST[1] + j];
        vec3 d = point.x * a + point.y * b + point.z * c;
        float d2 = dot(d, d);
        EACH_CHANNEL({ sum[c] += weight * point.w * profile_derivatives(dipoles[c], d2).x; })
    }
    if (ESTIMATE != 0) {
        ClusterMoments m = cluster_moments(node);
        vec3 d = self.x - m.center;
        float d2 = dot(d, d);
        EACH_CHANNEL({
            vec3 p = weight * profile_derivatives(dipoles[c], d2);
            float unit = unit_chi(p, d2, dipoles[c].z2.x);
            error[c] += missed_points(p, unit, m.diagonal.x + m.diagonal.y + m.diagonal.z);
        })
    }
}

void main() {
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    Runs run;
    self = near_receiver(run);
    first = run.first + run.expanded + run.direct;
    vec3 all, all_errors;
    sum_near(part.first, min(part.first + part.count, run.area), all, all_errors);
    if (!stores(self) || run.area <= part.first) return;
    vec3 before = area_received[self.face];
    area_received[self.face] = only_group(part.first == 0 ? all : before + all, before);
    if (ESTIMATE != 0) estimate[self.face] += only_group(all_errors, vec3(0));
}
