#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds the nearest triangles by the edge form, each at every receiver of the block.
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
UPDATES(edge_received)
UPDATES(estimate)
#include "dipole/form_factor/edge.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"
#include "transport/blocks/gather/receiver.glsl"
const bool ERRORS = ESTIMATE != 0;
#define NEAR_RUN 1 // one takes long
#include "transport/blocks/gather/near.glsl"

Receiver self;
uint first;

// A product that no sum takes in: one invocation alone adds it at once, a team later.
vec3 product(vec3 a, vec3 b) {
    precise vec3 both = a * b;
    return both;
}

void add(uint k) {
    uint node = entries[first + k], face = topology[node].face;
    // Lists that serve any light contain dark emitters.
    if (ANY_LIGHT != 0 && irradiance[face] == vec3(0)) return;
    vec3 z_real = object_params[0].z_real, z_virtual = object_params[0].z_virtual, sigma = object_params[0].sigma;
    Cluster emitter = clusters[node];
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x] - self.x, b = positions[corner.y] - self.x, c = positions[corner.z] - self.x;
    vec3 normal = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);
    float height = -dot(emitter.center - self.x, normal);
    vec3 foot = -height * normal;
    vec3 real = edge_form(sigma, a, b, c, corner, normal, foot, sqrt(height * height + z_real * z_real));
    vec3 virt = edge_form(sigma, a, b, c, corner, normal, foot, sqrt(height * height + z_virtual * z_virtual));
    vec3 value = product(irradiance[face], z_real * real + z_virtual * virt);
    sum += value;
    vec3 missed = missed_edge(NODES, sigma, emitter.moment_trace, object_params[0].strength * value);
    if (ESTIMATE != 0) error += product(missed, missed);
}

void main() {
    Runs run;
    self = near_receiver(run);
    first = run.first + run.expanded + run.direct + run.area;
    vec3 all, all_errors;
    sum_near(part.first, min(part.first + part.count, run.edge), all, all_errors);
    if (!stores(self) || run.edge <= part.first) return;
    vec3 before = edge_received[self.face], own = object_params[0].strength * all;
    edge_received[self.face] = only_group(part.first == 0 ? own : before + own, before);
    if (ESTIMATE != 0) estimate[self.face] += only_group(all_errors, vec3(0));
}
