#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds the nearest triangles by the edge form, each at every receiver of the block.
layout(local_size_x = GROUP_SIZE) in;
layout(constant_id = 0) const uint CHANNELS = 7;
layout(constant_id = 1) const uint NODES = 6;
layout(constant_id = 2) const uint ESTIMATE = 0;
layout(constant_id = 3) const uint ANY_LIGHT = 0;
layout(push_constant, scalar) uniform push_block { Range range; Range part; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(clusters)
READS(topology)
READS(triangles)
READS(positions)
READS(irradiance)
READS(runs)
READS(entries)
READS(near)
READS(near_groups)
UPDATES(received)
UPDATES(estimate)
#include "dipole/form_factor/edge.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"
#include "transport/blocks/gather/receiver.glsl"

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint place = group * gl_WorkGroupSize.x + gl_LocalInvocationIndex, blocks_near = near_groups[1].x;
    uint run_near = place / BLOCK_RECEIVERS;
    Receiver self = receiver_of(near[min(run_near, blocks_near - 1)], place, run_near < blocks_near);
    Runs run = runs[self.run];
    uint first = run.first + run.expanded + run.direct + run.area;
    vec3 z_real = object_params[0].z_real, z_virtual = object_params[0].z_virtual, sigma = object_params[0].sigma;
    vec3 sum = vec3(0), error = vec3(0);
    uint last = min(part.first + part.count, run.edge);
    for (uint k = part.first; k < last; ++k) {
        uint node = entries[first + k], face = topology[node].face;
        // Lists that serve any light contain dark emitters.
        if (ANY_LIGHT != 0 && irradiance[face] == vec3(0)) continue;
        Cluster emitter = clusters[node];
        uvec3 corner = triangles[face];
        vec3 a = positions[corner.x] - self.x, b = positions[corner.y] - self.x, c = positions[corner.z] - self.x;
        vec3 normal = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);
        float height = -dot(emitter.center - self.x, normal);
        vec3 foot = -height * normal;
        vec3 real = edge_form(sigma, a, b, c, corner, normal, foot, sqrt(height * height + z_real * z_real));
        vec3 virt = edge_form(sigma, a, b, c, corner, normal, foot, sqrt(height * height + z_virtual * z_virtual));
        vec3 value = irradiance[face] * (z_real * real + z_virtual * virt);
        sum += value;
        if (ESTIMATE != 0) error += missed_edge(NODES, sigma, emitter.moment_trace, object_params[0].strength * value);
    }
    if (!self.present || run.edge <= part.first) return;
    received[self.face] += only_group(object_params[0].strength * sum, vec3(0));
    if (ESTIMATE != 0) estimate[self.face] += only_group(error, vec3(0));
}
